"""One axis of an ODrive, whatever its firmware: its heartbeat says whether its positions count."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Protocol

from echogrid.drivers import cansimple
from echogrid.drivers.bus import CanFrame
from echogrid.drivers.cansimple import Heartbeat, Version
from echogrid.drivers.device import Health, Line, State, Step
from echogrid.drivers.limits import require_between
from echogrid.drivers.odrive_encoder import Encoder
from echogrid.drivers.odrive_inquiry import Inquiry
from echogrid.drivers.readings import WheelReading

HEARTBEAT_NS = 500_000_000
"""A position is believed so long after a heartbeat; they come every 100 ms by default."""


@dataclass(frozen=True, slots=True)
class AxisSettings:
    """The keys in a config file that are the same for every firmware."""

    node: int = 0
    """`axis.config.can.node_id`: by default 0 and 1 for the two axes of a board with 0.5, none with 0.6."""
    listen_only: bool = False
    """Send nothing at all: its firmware is taken as the driver's name says."""

    def __post_init__(self) -> None:
        require_between("node", self.node, 0, 0x3F)


class Firmware(Protocol):
    """What differs between the firmwares."""

    name: str
    """As in the driver's."""
    other: str
    """Which one it is mistaken for."""
    answers: bool
    """Whether it tells its version when it is asked: if not, that is how it is known."""

    def heartbeat(self, data: bytes) -> Heartbeat:
        """What the 8 bytes of a heartbeat say."""
        ...

    def fits(self, version: Version | None) -> bool:
        """Whether this is its version; None: it gave no answer."""
        ...


class CansimpleAxis:
    """Listens to one axis, and asks it for nothing but its firmware's version."""

    bus: ClassVar[str] = "can"
    line: ClassVar[type[Line[CanFrame, CanFrame]]] = Line
    identity: ClassVar[str] = "node"
    port_options: ClassVar[Mapping[str, object]] = {"bitrate": 250_000}

    def __init__(self, name: str, settings: AxisSettings, firmware: Firmware, encoder: Encoder) -> None:
        self.name = name
        self._node = settings.node
        self._firmware = firmware
        self._encoder = encoder
        self._inquiry = Inquiry(firmware.fits, settings.listen_only)
        self._counts = encoder.counts
        self._heartbeat: Heartbeat | None = None
        self._heartbeat_ns = 0
        self._position_ns: int | None = None

    def step(self, now_ns: int, received: Sequence[CanFrame]) -> Step[CanFrame]:
        """Take the axis's own frames in the order in which they came."""
        readings: list[WheelReading] = []
        asks = False
        for frame in received:
            command, stamp_ns = self._command(frame), frame.stamp_ns or now_ns
            if command == self._encoder.command:
                readings += self._position(stamp_ns, frame.data)
            elif command == cansimple.HEARTBEAT:
                asks |= self._beat(stamp_ns, self._firmware.heartbeat(frame.data))
            elif command == cansimple.VERSION:
                self._inquiry.told(cansimple.decode_version(frame.data))
        return Step(tuple(readings), (self._request(),) if asks else ())

    def lost(self, now_ns: int) -> None:  # noqa: ARG002 - as every device is told
        """The port was lost: nothing is believed until a heartbeat, and the axis may have restarted."""
        self._heartbeat = None
        self._encoder.lost()

    def health(self, now_ns: int) -> Health:
        """How it is."""
        state, message = self._condition(now_ns)
        return Health(state, message, dict(self._counts))

    def _condition(self, now_ns: int) -> tuple[State, str]:
        heartbeat = self._heartbeat  # its bus's thread may lose the port at any time
        if heartbeat is None or not self._alive(now_ns):
            return (
                State.SILENT,
                f"no heartbeat from node {self._node}: check its power, wires, node id and bit rate",
            )
        if stranger := self._stranger(heartbeat):
            return State.WRONG_DEVICE, stranger
        doubtful = "" if self._inquiry.right else f" (or is its firmware {self._firmware.other}?)"
        if heartbeat.faults:
            return State.FAILED, f"{heartbeat.faults}: clear it at the controller{doubtful}"
        if heartbeat.unsettled:
            return State.FAULTY, f"its position does not count yet: {heartbeat.unsettled}"
        if self._awaits_version():
            return State.SETTING_UP, "it was asked for its firmware's version"
        if self._position_ns is None or now_ns - self._position_ns > HEARTBEAT_NS:
            return State.STALLED, f"heartbeats, but no believable positions: {self._encoder.mend}"
        return State.WELL, "turning counted"

    def _stranger(self, heartbeat: Heartbeat) -> str:
        """Why it must be of another firmware than the driver's; empty if it need not."""
        version, mend = self._inquiry.version, f'set driver = "odrive-{self._firmware.other}"'
        if self._inquiry.wrong and version is None:
            return (
                f"it does not tell its version, as firmware {self._firmware.name} does: {mend}, or "
                "listen_only = true if it can't hear us"
            )
        if self._inquiry.wrong:
            known = f"{version}".startswith(f"{self._firmware.other}.")
            return f"its firmware is {version}: {mend if known else 'there is no driver for it'}"
        if heartbeat.unlike and version is None:
            return f"its heartbeat is none of firmware {self._firmware.name}: {mend}"
        return ""

    def _awaits_version(self) -> bool:
        return self._firmware.answers and not self._inquiry.right

    def _command(self, frame: CanFrame) -> int | None:
        """The command of a well-formed frame from this axis; any other is counted."""
        if frame.extended or frame.remote:
            self._counts["extended or remote frames"] += 1
        elif frame.identifier >> cansimple.COMMAND_BITS != self._node:
            self._counts["foreign frames"] += 1
        elif (command := frame.identifier & 0x1F) not in (
            cansimple.HEARTBEAT,
            cansimple.VERSION,
            self._encoder.command,
        ):
            self._counts["other frames"] += 1
        elif len(frame.data) != cansimple.LENGTH:
            self._counts["short frames"] += 1
        else:
            return command
        return None

    def _beat(self, stamp_ns: int, heartbeat: Heartbeat) -> bool:
        """Take a heartbeat, and tell whether to ask for the version."""
        self._counts["heartbeats"] += 1
        if not self._alive(stamp_ns):
            self._inquiry.forget()
        if not (self._alive(stamp_ns) and heartbeat.trustworthy):
            self._encoder.lost()
        if heartbeat.zeroed:
            self._encoder.restarted()
        self._heartbeat = heartbeat
        self._heartbeat_ns = stamp_ns
        return not heartbeat.unsettled and self._inquiry.request(stamp_ns)

    def _request(self) -> CanFrame:
        self._counts["version requests"] += 1
        return CanFrame(self._node << cansimple.COMMAND_BITS | cansimple.VERSION, b"", remote=True)

    def _alive(self, now_ns: int) -> bool:
        return self._heartbeat is not None and now_ns - self._heartbeat_ns <= HEARTBEAT_NS

    def _position(self, stamp_ns: int, data: bytes) -> tuple[WheelReading, ...]:
        if reason := self._doubt(stamp_ns):
            self._counts[reason] += 1
            return ()
        given = self._encoder.take(stamp_ns, data, self._heartbeat_ns)
        if given:
            self._position_ns = stamp_ns
        return given

    def _doubt(self, stamp_ns: int) -> str:
        """Why a position is not believed; empty if it is."""
        heartbeat = self._heartbeat
        if heartbeat is None or not self._alive(stamp_ns):
            return "positions without heartbeat"
        if self._stranger(heartbeat):
            return "positions of another firmware"
        if not heartbeat.trustworthy:
            return "positions of a faulty or starting axis"
        if self._awaits_version():
            return "positions before the version is known"
        return ""
