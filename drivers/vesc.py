"""VESC motor controllers, which send their status unasked: the tachometer counts the wheel's turns."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from struct import Struct
from typing import ClassVar, NamedTuple

from echogrid.drivers.bus import CanFrame
from echogrid.drivers.counter import CountedWheel, Scale
from echogrid.drivers.device import Health, Line, State, Step
from echogrid.drivers.freshness import is_old
from echogrid.drivers.limits import require_between
from echogrid.drivers.motor import Motor
from echogrid.drivers.readings import WheelReading
from echogrid.drivers.role import WheelRole
from echogrid.drivers.vesc_motor import VescCommands, erpm_per_radian

COUNTS_PER_ELECTRICAL_TURN = 6
"""One for every 60 electrical degrees (mcpwm_foc.c)."""
TACHOMETER_BITS = 32
LENGTH = 8

WARMTH_NS = 5_000_000_000
"""So long a temperature is remembered."""
BOOT_NS = 2_000_000_000
"""The status messages begin before the boot notice, which comes half a second later (main.c)."""
MOST_NAMED = 5
"""Identifiers of other controllers in a message."""
NO_STEERING = (
    "a VESC's tachometer begins anew at every power-up and can't tell an angle of steering: take an absolute "
    "encoder"
)


class Packet(IntEnum):
    """What a controller sends by itself: bits 15 to 8 of the identifier. 28 is no status."""

    STATUS = 9
    STATUS_2 = 14
    STATUS_3 = 15
    STATUS_4 = 16
    STATUS_5 = 27
    NOTIFY_BOOT = 57
    STATUS_6 = 58


SENT = frozenset(Packet)


class Motion(NamedTuple):
    """STATUS."""

    erpm: int
    """Electrical turns per minute."""
    amperes: float
    duty: float
    """-1 to 1."""


class Warmth(NamedTuple):
    """STATUS_4."""

    fet_c: float
    motor_c: float
    amperes: float
    """From the supply."""
    position_deg: float
    """Of the position controller."""


class Tachometer(NamedTuple):
    """STATUS_5."""

    sixths: int
    """Of an electrical turn."""
    volts: float


_STATUS = Struct(">ihh")
_STATUS_4 = Struct(">hhhh")
_STATUS_5 = Struct(">ihxx")


def decode_status(data: bytes) -> Motion:
    """What the 8 bytes of STATUS say."""
    erpm, amperes, duty = _STATUS.unpack(data)
    return Motion(erpm, amperes / 10, duty / 1000)


def decode_status_4(data: bytes) -> Warmth:
    """What the 8 bytes of STATUS_4 say."""
    fet, motor, amperes, position = _STATUS_4.unpack(data)
    return Warmth(fet / 10, motor / 10, amperes / 10, position / 50)


def decode_status_5(data: bytes) -> Tachometer:
    """What the 8 bytes of STATUS_5 say."""
    sixths, volts = _STATUS_5.unpack(data)
    return Tachometer(sixths, volts / 10)


class Vesc:
    """One controller, which is only listened to until a rate is asked for."""

    bus: ClassVar[str] = "can"
    line: ClassVar[type[Line[CanFrame, CanFrame]]] = Line
    identity: ClassVar[str] = "node"
    port_options: ClassVar[Mapping[str, object]] = {"bitrate": 500_000}

    @dataclass(frozen=True, slots=True)
    class Settings:
        """Its keys in a config file."""

        node: int = 0
        """`controller_id`, the VESC's ID in VESC Tool."""
        pole_pairs: int = 7
        """Half the magnets of the motor."""
        hottest_fet_c: float = 85.0
        hottest_motor_c: float = 85.0
        """Warmer than that it is told as hot."""
        brake_amperes: float = 5.0
        """Motor current with which it is braked when it shall stand."""

        def __post_init__(self) -> None:
            require_between("node", self.node, 0, 254)
            require_between("pole_pairs", self.pole_pairs, 1, 100)
            require_between("hottest_fet_c", self.hottest_fet_c, 0.0, 200.0)
            require_between("hottest_motor_c", self.hottest_motor_c, 0.0, 200.0)
            require_between("brake_amperes", self.brake_amperes, 0.0, 200.0)

    def __init__(self, role: WheelRole, settings: Settings) -> None:
        """Raises ValueError if it shall tell an angle of steering."""
        if role.steering is not None:
            raise ValueError(NO_STEERING)
        self.name = role.name
        self._settings = settings
        per_turn = COUNTS_PER_ELECTRICAL_TURN * settings.pole_pairs
        self._wheel = CountedWheel(role, Scale(1 << TACHOMETER_BITS, per_turn))
        self._counts = self._wheel.counts
        erpm = erpm_per_radian(role.gear, settings.pole_pairs)
        commands = VescCommands(settings.node, erpm, settings.brake_amperes)
        self._motor = Motor(role.throttle, commands)
        self._others: set[int] = set()
        self._heard_ns: int | None = None
        self._tachometer_ns: int | None = None
        self._motion: tuple[int, Motion] | None = None
        self._warmth: tuple[int, Warmth] | None = None

    def step(self, now_ns: int, received: Sequence[CanFrame]) -> Step[CanFrame]:
        """Take the controller's own frames in the order in which they came."""
        readings: list[WheelReading] = []
        for frame in received:
            packet = self._packet(frame)
            if packet is not None:
                readings += self._take(packet, frame.stamp_ns or now_ns, frame.data)
        able = not is_old(self._heard_ns, now_ns)
        send = self._motor.step(now_ns, driven=True, able=able)
        return Step(tuple(readings), tuple(send), self._motor.deadline_ns)

    def parting(self, now_ns: int) -> Sequence[CanFrame]:  # noqa: ARG002 - as every device is told
        """What stops the motor, if it was taken."""
        return self._motor.parting()

    def lost(self, now_ns: int) -> None:  # noqa: ARG002 - as every device is told
        """The port was lost: what was heard counts no more, and the controller may have restarted."""
        self._heard_ns = self._tachometer_ns = self._motion = self._warmth = None
        self._wheel.lost()
        self._motor.lost()

    def health(self, now_ns: int) -> Health:
        """How it is."""
        state, message = self._condition(now_ns)
        return Health(state, message, dict(self._counts))

    def _condition(self, now_ns: int) -> tuple[State, str]:
        node = self._settings.node
        if is_old(self._heard_ns, now_ns):
            return (
                State.SILENT,
                f"no status from VESC {node}{self._neighbours()}: check its power, wires, ID and bit rate, "
                "that its CAN mode is VESC, and that it sends status messages",
            )
        if is_old(self._tachometer_ns, now_ns):
            return (
                State.STALLED,
                "status messages, but no tachometer: let it send STATUS_5 (bit 4, 0x10, of "
                "can_status_msgs_r1) at 10 Hz or more",
            )
        if is_old(self._wheel.believed_ns, now_ns):
            return (
                State.FAULTY,
                "its tachometer jumps further than the wheel can turn: are pole_pairs, gear and "
                f"fastest_rad_s right, and is there one VESC {node} only?",
            )
        if hot := self._hot(now_ns):
            return State.HOT, f"{hot}: it gives less current soon; let it cool, load it less"
        if self._motor.waits(now_ns):
            return State.WELL, "turning counted; it turns after a command to stand"
        return State.WELL, "turning counted"

    def _neighbours(self) -> str:
        if not self._others:
            return ""
        named = ", ".join(str(node) for node in sorted(self._others)[:MOST_NAMED])
        return f" (heard of: {named})"

    def _hot(self, now_ns: int) -> str:
        """What is too warm; empty if nothing is, or if it does not tell."""
        warmth = self._warmth  # its bus's thread may lose the port at any time
        if warmth is None or is_old(warmth[0], now_ns, WARMTH_NS):
            return ""
        parts = (
            ("FETs", warmth[1].fet_c, self._settings.hottest_fet_c),
            ("motor", warmth[1].motor_c, self._settings.hottest_motor_c),
        )
        return ", ".join(f"{part} at {celsius:.1f} C" for part, celsius, most in parts if celsius > most)

    def _packet(self, frame: CanFrame) -> Packet | None:
        """What kind of well-formed frame of this controller it is; any other is counted."""
        kind = frame.identifier >> 8
        if not frame.extended or frame.remote:
            self._counts["standard or remote frames"] += 1
        elif frame.identifier & 0xFF != self._settings.node:
            self._counts["foreign frames"] += 1
            if kind in SENT:
                self._others.add(frame.identifier & 0xFF)
        elif kind not in SENT:
            self._counts["other frames"] += 1
        elif kind != Packet.NOTIFY_BOOT and len(frame.data) != LENGTH:
            self._counts["short frames"] += 1
        else:
            return Packet(kind)
        return None

    def _take(self, packet: Packet, stamp_ns: int, data: bytes) -> tuple[WheelReading, ...]:
        self._wheel.heard(stamp_ns)
        self._heard_ns = stamp_ns
        if packet is Packet.STATUS_5:
            self._tachometer_ns = stamp_ns
            return self._wheel.read(stamp_ns, decode_status_5(data).sixths, data, self._rate(stamp_ns))
        if packet is Packet.STATUS:
            self._motion = stamp_ns, decode_status(data)
        elif packet is Packet.STATUS_4:
            self._warmth = stamp_ns, decode_status_4(data)
        elif packet is Packet.NOTIFY_BOOT:
            self._booted(stamp_ns)
        return ()

    def _booted(self, stamp_ns: int) -> None:
        """It says that it has restarted; its first counts may have shown that already."""
        self._counts["boot notices"] += 1
        rebased_ns = self._wheel.rebased_ns
        if rebased_ns is None or stamp_ns - rebased_ns > BOOT_NS:
            self._wheel.restarted()

    def _rate(self, now_ns: int) -> float | None:
        """Turns/s of the motor, if it tells its speed."""
        if self._motion is None or is_old(self._motion[0], now_ns):
            return None
        return self._motion[1].erpm / 60 / self._settings.pole_pairs
