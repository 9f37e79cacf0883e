"""One axis of an ODrive, whatever its firmware: its heartbeat says whether its positions count."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Protocol

from echogrid.drivers import cansimple
from echogrid.drivers.bus import CanFrame
from echogrid.drivers.cansimple import Heartbeat, Version
from echogrid.drivers.device import Health, Line, State, Step
from echogrid.drivers.limits import require_between
from echogrid.drivers.motor import Motor
from echogrid.drivers.odrive_encoder import Encoder
from echogrid.drivers.odrive_inquiry import Inquiry
from echogrid.drivers.odrive_motor import CLOSED_LOOP, OdriveCommands
from echogrid.drivers.readings import WheelReading
from echogrid.drivers.role import WheelRole

HEARTBEAT_NS = 500_000_000
"""A position is believed so long after a heartbeat; they come every 100 ms by default."""

WITHOUT_WATCHDOG = (
    "it can't be driven without its own watchdog, which stops it when we are gone: set "
    "axis.config.watchdog_timeout (0.5) and enable_watchdog at the controller, then watchdog = true here"
)


@dataclass(frozen=True, slots=True)
class AxisSettings:
    """The keys in a config file that are the same for every firmware."""

    node: int = 0
    """`axis.config.can.node_id`: by default 0 and 1 for the two axes of a board with 0.5, none with 0.6."""
    watchdog: bool = False
    """`axis.config.enable_watchdog` is on: only then it is driven, for else it would turn on without us."""

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
    clear: bytes
    """The data of its Clear_Errors."""
    idle_expires: bool
    """Whether the watchdog also expires while it is idle: if not, nobody can see that it is on."""

    def heartbeat(self, data: bytes) -> Heartbeat:
        """What the 8 bytes of a heartbeat say."""
        ...

    def fits(self, version: Version | None) -> bool:
        """Whether this is its version; None: it gave no answer."""
        ...


class CansimpleAxis:
    """Listens to one axis, and asks it for nothing but its firmware's version, until a rate is asked for.

    Then it is enabled in velocity control, after an error of its own watchdog was cleared, which is there
    whenever nobody commanded the axis.
    """

    bus: ClassVar[str] = "can"
    line: ClassVar[type[Line[CanFrame, CanFrame]]] = Line
    identity: ClassVar[str] = "node"
    port_options: ClassVar[Mapping[str, object]] = {"bitrate": 250_000}

    def __init__(self, role: WheelRole, settings: AxisSettings, firmware: Firmware, encoder: Encoder) -> None:
        if role.throttle is not None and not settings.watchdog:
            raise ValueError(WITHOUT_WATCHDOG)
        self.name = role.name
        self._node = settings.node
        self._firmware = firmware
        self._encoder = encoder
        self._throttled = role.throttle is not None
        self._inquiry = Inquiry(firmware.fits, role.listen_only)
        self._commands = OdriveCommands(settings.node, role.gear, firmware.clear)
        self._motor = Motor(role.throttle, self._commands)
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
        request = (self._request(),) if asks else ()
        return Step(tuple(readings), (*request, *self._driven(now_ns)), self._motor.deadline_ns)

    def parting(self, now_ns: int) -> Sequence[CanFrame]:  # noqa: ARG002 - as every device is told
        """What lets the motor go, if it was taken."""
        return self._motor.parting()

    def lost(self, now_ns: int) -> None:  # noqa: ARG002 - as every device is told
        """The port was lost: nothing is believed until a heartbeat, and the axis may have restarted."""
        self._heartbeat = None
        self._encoder.lost()
        self._motor.lost()
        self._commands.enabled = False

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
        if heartbeat.faults and not heartbeat.expired:
            return State.FAILED, f"{heartbeat.faults}: clear it at the controller{doubtful}"
        if heartbeat.unsettled:
            return State.FAULTY, f"its position does not count yet: {heartbeat.unsettled}"
        if self._awaits_version():
            return State.SETTING_UP, "it was asked for its firmware's version"
        if self._position_ns is None or now_ns - self._position_ns > HEARTBEAT_NS:
            return State.STALLED, f"heartbeats, but no believable positions: {self._encoder.mend}"
        return State.WELL, f"turning counted{self._waits_for(now_ns)}"

    def _waits_for(self, now_ns: int) -> str:
        """What must come before its motor turns; empty if nothing must, or nobody wants it to."""
        if not self._motor.asked(now_ns) or self._motor.obeys:
            return ""
        if self._usurped:
            return "; in closed loop by somebody else: set it idle, and startup_closed_loop_control off"
        if not self._watched:
            return "; enabled when its watchdog is seen to expire: is axis.config.enable_watchdog on?"
        return "; it turns after a command to stand" if self._motor.waits(now_ns) else "; being enabled"

    def _driven(self, now_ns: int) -> Sequence[CanFrame]:
        """What its motor is told."""
        if not self._throttled:
            return ()
        heartbeat = self._heartbeat
        if heartbeat is None or not self._alive(now_ns):
            return self._motor.step(now_ns, driven=False, able=False)
        self._commands.expired = heartbeat.expired
        able = self._inquiry.right and self._watched and not (heartbeat.unsettled or self._usurped)
        able = able and (heartbeat.expired or not heartbeat.faults)
        return self._motor.step(now_ns, heartbeat.state == CLOSED_LOOP, able)

    @property
    def _usurped(self) -> bool:
        """Whether it is in closed loop, but not by us: in what mode, with which watchdog, nobody knows."""
        heartbeat = self._heartbeat
        return heartbeat is not None and heartbeat.state == CLOSED_LOOP and not self._commands.enabled

    @property
    def _watched(self) -> bool:
        """Whether its watchdog is seen to be on, or can't be seen: an idle axis that nobody feeds expires."""
        heartbeat = self._heartbeat
        if heartbeat is None or not self._firmware.idle_expires:
            return True
        return heartbeat.expired or heartbeat.state == CLOSED_LOOP

    def _stranger(self, heartbeat: Heartbeat) -> str:
        """Why it must be of another firmware than the driver's; empty if it need not."""
        version, mend = self._inquiry.version, f'set driver = "odrive-{self._firmware.other}"'
        if self._inquiry.wrong and version is None:
            return (
                f"it does not tell its version, as firmware {self._firmware.name} does: {mend}, or "
                "listen_only = true at the bus if it can't hear us"
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
