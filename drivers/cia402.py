"""One axis of a CANopen drive (CiA 402): set up by SDO, started, and then listened to."""

from collections.abc import Mapping, Sequence
from struct import Struct
from typing import ClassVar

from echogrid.drivers import canopen
from echogrid.drivers.bus import NEVER_NS, CanFrame
from echogrid.drivers.canopen import Command, NmtState
from echogrid.drivers.cia402_motor import VelocityCommands
from echogrid.drivers.cia402_report import STATUS, DriveReport
from echogrid.drivers.cia402_settings import Cia402Settings
from echogrid.drivers.cia402_setup import SetUp
from echogrid.drivers.cia402_state import FAULTS, DriveState
from echogrid.drivers.counter import CountedWheel, Scale
from echogrid.drivers.device import Health, Line, State, Step
from echogrid.drivers.motor import Motor
from echogrid.drivers.readings import WheelReading
from echogrid.drivers.role import WheelRole
from echogrid.drivers.ticker import Ticker

POSITION_NS = 500_000_000
"""So old a position may be."""
START_NS = 500_000_000
"""From one NMT start to the next, while it is not operational."""

_MOTION = Struct("<ii")


def decode_motion(data: bytes) -> tuple[int, int]:
    """Position and velocity, in the drive's units, in the 8 bytes of 6064h and 606Ch."""
    position, velocity = _MOTION.unpack(data)
    return position, velocity


class Cia402Axis:
    """Sends nothing that could enable a motor before a rate is asked for."""

    bus: ClassVar[str] = "can"
    line: ClassVar[type[Line[CanFrame, CanFrame]]] = Line
    identity: ClassVar[str] = "node"
    port_options: ClassVar[Mapping[str, object]] = {"bitrate": 500_000}
    Settings = Cia402Settings

    def __init__(self, role: WheelRole, settings: Cia402Settings) -> None:
        self.name = role.name
        self._settings = settings
        configures = settings.configure and not role.listen_only
        if role.throttle is not None and not configures:
            raise ValueError("its motor can't be commanded without configure = true: an RPDO must be set up")
        self._setup = SetUp(settings) if configures else None
        self._commands = VelocityCommands(settings, role.gear)
        self._motor = Motor(role.throttle, self._commands)
        self._wheel = CountedWheel(role, Scale(settings.modulus, settings.counts_per_turn))
        self._counts = self._wheel.counts
        self._sync = Ticker(settings.period_ms * 1_000_000)
        self._start = Ticker(START_NS)
        self._report = DriveReport(settings.heartbeat_ms)
        self._parts = _parts(settings)
        self._position_ns: int | None = None

    def step(self, now_ns: int, received: Sequence[CanFrame]) -> Step[CanFrame]:
        """Take the drive's own frames in the order in which they came; set it up, start it, drive it."""
        readings: list[WheelReading] = []
        for frame in received:
            if part := self._part(frame):
                readings += self._take(part, frame.stamp_ns or now_ns, frame.data)
        send: tuple[CanFrame, ...] = ()
        if self._setup is not None:
            send = self._synchronised(now_ns, bool(received))
            send += (*self._prepared(self._setup, now_ns), *self._driven(self._setup, now_ns))
        return Step(tuple(readings), send, self._deadline_ns(now_ns))

    def parting(self, now_ns: int) -> Sequence[CanFrame]:  # noqa: ARG002 - as every device is told
        """What lets the motor go, if it was taken."""
        return self._motor.parting()

    def lost(self, now_ns: int) -> None:
        """The port was lost: nothing is believed until a heartbeat, and the drive may have restarted."""
        self._motor.lost()
        self._commands.forget()
        self._report.forget()
        self._position_ns = None
        self._wheel.lost()
        self._sync.stop()
        self._set_up_again(now_ns)

    def health(self, now_ns: int) -> Health:
        """How it is."""
        state, message = self._condition(now_ns)
        return Health(state, message, dict(self._counts))

    def _part(self, frame: CanFrame) -> str:
        """Which part of the drive has sent a well-formed frame; any other is counted."""
        name, length = self._parts.get(frame.identifier, ("", 0))
        if frame.extended or frame.remote:
            self._counts["extended or remote frames"] += 1
        elif not name:
            self._counts["foreign frames"] += 1
        elif len(frame.data) != length:
            self._counts[f"{name} frames of a wrong length"] += 1
        else:
            return name
        return ""

    def _take(self, part: str, stamp_ns: int, data: bytes) -> tuple[WheelReading, ...]:
        self._wheel.heard(stamp_ns)
        self._report.heard_ns = stamp_ns
        if part == "position":
            return self._position(stamp_ns, data)
        if part == "heartbeat":
            self._heartbeat(stamp_ns, canopen.decode_heartbeat(data))
        elif part == "status":
            self._report.told_status(stamp_ns, data)
        elif part == "emergency":
            self._counts["emergencies"] += self._report.told_emergency(data)
        elif not self._replied(data):
            self._counts["unexpected replies"] += 1
        return ()

    def _heartbeat(self, stamp_ns: int, state: int) -> None:
        if state == NmtState.BOOT:
            self._counts["restarts"] += 1
            self._report.restarted()
            self._wheel.restarted()
            self._set_up_again(stamp_ns)
        self._report.beat = stamp_ns, state

    def _replied(self, data: bytes) -> bool:
        return (self._setup is not None and self._setup.take(data)) or self._commands.take(data)

    def _position(self, stamp_ns: int, data: bytes) -> tuple[WheelReading, ...]:
        if reason := self._doubt(stamp_ns):
            self._counts[reason] += 1
            return ()
        self._position_ns = stamp_ns
        position, velocity = decode_motion(data)
        return self._wheel.read(stamp_ns, position, data, velocity / self._settings.units_per_turn)

    def _doubt(self, stamp_ns: int) -> str:
        """Why a position is not believed; empty if it is."""
        if self._setup is not None and not self._setup.done:
            return "positions before the set-up"
        if not self._report.alive(stamp_ns):
            return "positions without heartbeat"
        if not self._report.operational(stamp_ns):
            return "positions of a node that is not operational"
        if self._report.blind:
            self._wheel.restarted()
            return "positions of a faulty encoder"
        return ""

    def _synchronised(self, now_ns: int, heard: bool) -> tuple[CanFrame, ...]:
        """SYNC, for all drives on the bus: so it does not depend on this one, but on anybody being there."""
        if heard and self._settings.sync == "produce":
            self._sync.start(now_ns)
        return (canopen.sync(),) if self._sync.due(now_ns) else ()

    def _prepared(self, setup: SetUp, now_ns: int) -> tuple[CanFrame, ...]:
        """Its set-up, and the signal to start it."""
        if setup.done and not self._report.alive(now_ns):
            self._set_up_again(now_ns)
        was_done = setup.done
        send = setup.step(now_ns)
        if not setup.done:
            return send
        if not was_done:
            self._report.beat = now_ns, NmtState.PRE_OPERATIONAL
            self._start.start(now_ns)
        if not self._report.operational(now_ns) and self._start.due(now_ns):
            send += (canopen.nmt(Command.START, self._settings.node),)
        return send

    def _set_up_again(self, now_ns: int) -> None:
        if self._setup is not None:
            self._setup.begin(now_ns)
            self._start.stop()

    def _driven(self, setup: SetUp, now_ns: int) -> tuple[CanFrame, ...]:
        """What its motor is told; it is stopped once if it no longer can be led."""
        state = self._report.state(now_ns)
        able = setup.done and self._report.operational(now_ns) and state is not None and state not in FAULTS
        self._commands.state = state
        driven = self._commands.prepared and state is DriveState.ENABLED
        told = self._motor.step(now_ns, driven, able)
        return (*told, *self._commands.step(now_ns))

    def _deadline_ns(self, now_ns: int) -> int:
        if self._setup is None:
            return NEVER_NS
        timers = (self._setup.deadline_ns, self._sync.deadline_ns, self._commands.deadline_ns)
        deadline_ns = min(self._motor.deadline_ns, *timers)
        if not self._setup.done:
            return deadline_ns
        if not self._report.operational(now_ns):
            deadline_ns = min(deadline_ns, self._start.deadline_ns)
        beat = self._report.beat
        return min(deadline_ns, (beat[0] if beat else now_ns) + self._report.patience_ns + 1)

    def _condition(self, now_ns: int) -> tuple[State, str]:
        node = self._settings.node
        if not self._report.heard(now_ns):
            return (
                State.SILENT,
                f"nothing comes from node {node}: check its power, wires, node id and bit rate",
            )
        if self._setup is not None and not self._setup.done:
            return self._setup.outcome or (State.SETTING_UP, f"node {node} is being told what to send")
        if not self._report.alive(now_ns):
            return State.SILENT, f"no heartbeat from node {node}: let it send one (1017h)"
        if fault := self._report.fault(now_ns):
            return State.FAILED, f"{fault}: clear it at the drive, or switch it off and on"
        if not self._report.operational(now_ns):
            mend = "it was told to start" if self._setup is not None else "its master must start it (NMT)"
            return State.STALLED, f"it is {self._report.network_state}, and sends no positions: {mend}"
        return self._counting(now_ns)

    def _counting(self, now_ns: int) -> tuple[State, str]:
        settings = self._settings
        if self._position_ns is None or now_ns - self._position_ns > POSITION_NS:
            sync = "does anybody send SYNC, and " if settings.sync == "expect" else ""
            return (
                State.STALLED,
                f"heartbeats, but no positions in TPDO{settings.tpdo}: {sync}does it hold 6064h and 606Ch, "
                "in 8 bytes?",
            )
        believed_ns = self._wheel.believed_ns
        if believed_ns is None or now_ns - believed_ns > POSITION_NS:
            return (
                State.FAULTY,
                "its position jumps further than the wheel can turn: are counts_per_turn, range_counts, gear "
                f"and fastest_rad_s right, and is there one node {settings.node} only?",
            )
        if self._commands.trouble:
            return State.FAILED, f"its motor can't be commanded: {self._commands.trouble}"
        return State.WELL, "; ".join(("turning counted", *self._remarks(now_ns)))

    def _remarks(self, now_ns: int) -> Sequence[str]:
        """What else is to be known while it counts."""
        remarks = [*self._report.remarks(now_ns)]
        if self._motor.waits(now_ns):
            remarks.append("it turns after a command to stand")
        return remarks


def _parts(settings: Cia402Settings) -> dict[int, tuple[str, int]]:
    """What a drive sends, by identifier, and how many bytes that has."""
    node = settings.node
    return {
        canopen.HEARTBEAT + node: ("heartbeat", 1),
        canopen.EMERGENCY + node: ("emergency", canopen.LENGTH),
        canopen.SDO_REPLY + node: ("reply", canopen.LENGTH),
        canopen.tpdo(settings.tpdo, node): ("position", _MOTION.size),
        canopen.tpdo(settings.status_tpdo, node): ("status", STATUS.size),
    }
