"""CubeMars AK actuators in servo mode, which send position, speed, current and temperature unasked."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from struct import Struct
from typing import ClassVar, NamedTuple

from echogrid.drivers.bus import CanFrame
from echogrid.drivers.counter import CountedWheel, Scale
from echogrid.drivers.device import Health, Line, State, Step
from echogrid.drivers.freshness import is_old
from echogrid.drivers.limits import require_between
from echogrid.drivers.readings import WheelReading
from echogrid.drivers.role import WheelRole

COUNTS_PER_TURN = 3600
LENGTH = 8

ENDS = frozenset({-32768, -32000, 32000, 32767})
"""Positions at which it may stop counting: those of the manual's range, and of the 16 bits."""

ENCODER_FAULT = 5
ERRORS = {
    1: "over-temperature",
    2: "over-current",
    3: "over-voltage",
    4: "under-voltage",
    ENCODER_FAULT: "encoder fault",
    6: "unbalanced phase currents",
}


class Upload(NamedTuple):
    """What an actuator says of itself."""

    position: int
    """0.1 deg."""
    erpm: int
    """Electrical turns per minute."""
    amperes: float
    celsius: int
    error: int


_UPLOAD = Struct(">hhhbB")


def decode_upload(data: bytes) -> Upload:
    """What the 8 bytes of an upload say."""
    position, tens_of_erpm, amperes, celsius, error = _UPLOAD.unpack(data)
    return Upload(position, tens_of_erpm * 10, amperes / 100, celsius, error)


class AkServo:
    """One actuator that is only listened to."""

    bus: ClassVar[str] = "can"
    line: ClassVar[type[Line[CanFrame, CanFrame]]] = Line
    identity: ClassVar[str] = "node"
    port_options: ClassVar[Mapping[str, object]] = {"bitrate": 1_000_000}

    @dataclass(frozen=True, slots=True)
    class Settings:
        """Its keys in a config file."""

        node: int = 0
        """The actuator's id."""
        packet: int = 0x29
        """The identifier's bits above the id's eight."""
        span_deg: float = 6553.6
        """So far the position goes from one wrap to the next."""
        hottest_c: float = 80.0
        """Warmer than that it is told as hot."""

        def __post_init__(self) -> None:
            require_between("node", self.node, 0, 0xFF)
            require_between("packet", self.packet, 0, 0x1F_FFFF)
            require_between("span_deg", self.span_deg, 360.0, 6553.6)
            require_between("hottest_c", self.hottest_c, 0.0, 127.0)

    def __init__(self, role: WheelRole, settings: Settings) -> None:
        self.name = role.name
        self._settings = settings
        self._identifier = settings.packet << 8 | settings.node
        self._wheel = CountedWheel(role, Scale(round(settings.span_deg * 10), COUNTS_PER_TURN))
        self._counts = self._wheel.counts
        self._upload: tuple[int, Upload] | None = None

    def step(self, now_ns: int, received: Sequence[CanFrame]) -> Step[CanFrame]:
        """Take the actuator's own frames in the order in which they came."""
        readings: list[WheelReading] = []
        for frame in received:
            if self._own(frame):
                readings += self._take(frame.stamp_ns or now_ns, frame.data)
        return Step(tuple(readings))

    def lost(self, now_ns: int) -> None:  # noqa: ARG002 - as every device is told
        """The port was lost: what was heard counts no more, and the actuator may have restarted."""
        self._upload = None
        self._wheel.lost()

    def health(self, now_ns: int) -> Health:
        """How it is."""
        state, message = self._condition(now_ns)
        return Health(state, message, dict(self._counts))

    def _condition(self, now_ns: int) -> tuple[State, str]:
        heard = self._upload  # its bus's thread may lose the port at any time
        if heard is None or is_old(heard[0], now_ns):
            return (
                State.SILENT,
                f"no upload with the identifier {self._identifier:#x}: check its power, wires, id and bit "
                "rate, that it is in servo mode, and that it uploads at 10 Hz or more",
            )
        upload = heard[1]
        if upload.error:
            fault = ERRORS.get(upload.error, f"error {upload.error}")
            return State.FAILED, f"{fault}: clear it at the actuator"
        if is_old(self._wheel.believed_ns, now_ns):
            return (
                State.FAULTY,
                f"no believable positions (now {upload.position / 10:.1f} deg): does it stop counting at the "
                "end of its range, are span_deg, gear and fastest_rad_s right, is its id its own?",
            )
        if upload.celsius > self._settings.hottest_c:
            return State.HOT, f"driver at {upload.celsius} C: let it cool, load it less"
        return State.WELL, "turning counted"

    def _own(self, frame: CanFrame) -> bool:
        """Whether it is a well-formed frame of this actuator; any other is counted."""
        if not frame.extended or frame.remote:
            self._counts["standard or remote frames"] += 1
        elif frame.identifier != self._identifier:
            self._counts["foreign frames"] += 1
        elif len(frame.data) != LENGTH:
            self._counts["short frames"] += 1
        else:
            return True
        return False

    def _take(self, stamp_ns: int, data: bytes) -> tuple[WheelReading, ...]:
        before, upload = self._upload, decode_upload(data)
        self._wheel.heard(stamp_ns)
        self._upload = stamp_ns, upload
        if reason := self._nonsense(upload):
            self._counts[reason] += 1
            self._wheel.restarted()
            return ()
        if upload.position in ENDS and self._held(before, upload):
            return ()
        return self._wheel.read(stamp_ns, upload.position, data)

    def _nonsense(self, upload: Upload) -> str:
        """Why a position says nothing; empty if it does."""
        if upload.error == ENCODER_FAULT:
            return "positions of a faulty encoder"
        if abs(upload.position) > self._settings.span_deg * 5:
            return "positions beyond span_deg"
        return ""

    def _held(self, before: tuple[int, Upload] | None, upload: Upload) -> bool:
        """Whether to wait for the next one, as it turns: only that shows whether it goes on counting."""
        if before is not None and before[1].position == upload.position and before[1].erpm:
            self._wheel.restarted()
        self._counts["positions held at an end"] += bool(upload.erpm)
        return bool(upload.erpm)
