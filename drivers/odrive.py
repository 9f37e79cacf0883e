"""ODrive's CANSimple protocol, firmware 0.5: an axis that sends heartbeats and encoder estimates unasked."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum, IntFlag
from math import isfinite
from struct import Struct
from typing import ClassVar

from echogrid.drivers.bus import CanFrame
from echogrid.drivers.device import Health, Line, State, Step
from echogrid.drivers.limits import require_between
from echogrid.drivers.readings import WheelReading
from echogrid.drivers.role import WheelRole
from echogrid.drivers.wheel_angle import WheelAngle

HEARTBEAT = 0x001
ESTIMATES = 0x009
COMMAND_BITS = 5
LENGTH = 8

HEARTBEAT_NS = 500_000_000
"""An estimate is believed so long after a heartbeat; they come every 100 ms by default."""
ESTIMATE_ERROR_NS = 1_000_000
"""A full bus holds a frame back for about two others."""


class AxisState(IntEnum):
    """States in which the position may be zeroed, and in which it therefore does not count."""

    UNDEFINED = 0
    STARTUP = 2
    FULL_CALIBRATION = 3
    INDEX_SEARCH = 6
    OFFSET_CALIBRATION = 7
    HOMING = 11
    HALL_POLARITY_CALIBRATION = 12
    HALL_PHASE_CALIBRATION = 13


UNSETTLED = frozenset(AxisState)


class AxisError(IntFlag):
    """The axis errors of firmware 0.5."""

    INVALID_STATE = 0x1
    MOTOR_FAILED = 0x40
    SENSORLESS_ESTIMATOR_FAILED = 0x80
    ENCODER_FAILED = 0x100
    CONTROLLER_FAILED = 0x200
    WATCHDOG_TIMER_EXPIRED = 0x800
    MIN_ENDSTOP_PRESSED = 0x1000
    MAX_ENDSTOP_PRESSED = 0x2000
    ESTOP_REQUESTED = 0x4000
    HOMING_WITHOUT_ENDSTOP = 0x20000
    OVER_TEMP = 0x40000
    UNKNOWN_POSITION = 0x80000


@dataclass(frozen=True, slots=True)
class Heartbeat:
    """What an axis says of itself."""

    error: int
    state: int
    motor_error: bool
    encoder_error: bool
    controller_error: bool
    trajectory_done: bool

    @property
    def trustworthy(self) -> bool:
        """Whether its estimates are facts. An encoder without them is reported as standing at 0."""
        return not self.error and not self.encoder_error and self.state not in UNSETTLED

    def faults(self) -> str:
        """Its errors by name; empty if there are none."""
        names = [flag.name or "" for flag in AxisError if flag & self.error]
        if self.error and not names:
            names = [f"axis error {self.error:#x}"]
        flags = (
            ("motor", self.motor_error),
            ("encoder", self.encoder_error),
            ("controller", self.controller_error),
        )
        return ", ".join(names + [f"{part} error" for part, wrong in flags if wrong])


_HEARTBEAT = Struct("<IBBBB")
_ESTIMATES = Struct("<ff")


def decode_heartbeat(data: bytes) -> Heartbeat:
    """What the 8 bytes of a heartbeat say."""
    error, state, motor, encoder, controller = _HEARTBEAT.unpack(data)
    return Heartbeat(
        error, state, bool(motor & 1), bool(encoder & 1), bool(controller & 1), bool(controller & 0x80)
    )


def decode_estimates(data: bytes) -> tuple[float, float]:
    """Position (turns) and velocity (turns/s) in the 8 bytes of the encoder's estimates."""
    position, velocity = _ESTIMATES.unpack(data)
    return position, velocity


class ODriveAxis:
    """One axis that is only listened to; its heartbeat says whether its estimates count."""

    bus: ClassVar[str] = "can"
    line: ClassVar[type[Line[CanFrame, CanFrame]]] = Line
    identity: ClassVar[str] = "node"
    port_options: ClassVar[Mapping[str, object]] = {"bitrate": 250_000}

    @dataclass(frozen=True, slots=True)
    class Settings:
        """Its keys in a config file."""

        node: int = 0
        """`axis.config.can.node_id`: by default 0 and 1 for the two axes of a board."""

        def __post_init__(self) -> None:
            require_between("node", self.node, 0, 0x3F)

    def __init__(self, role: WheelRole, settings: Settings) -> None:
        self.name = role.name
        self._node = settings.node
        self._angle = WheelAngle(role.gear, role.fastest)
        self._counts: Counter[str] = Counter()
        self._heartbeat: Heartbeat | None = None
        self._heartbeat_ns = 0
        self._estimate_ns: int | None = None
        self._turns = 0.0
        self._zeros_ns: int | None = None
        self._gap = False
        self._restarted = False

    def step(self, now_ns: int, received: Sequence[CanFrame]) -> Step[CanFrame]:
        """Take the axis's own frames in the order in which they came."""
        readings: list[WheelReading] = []
        for frame in received:
            command = self._command(frame)
            if command == HEARTBEAT:
                self._beat(frame.stamp_ns or now_ns, decode_heartbeat(frame.data))
            elif command == ESTIMATES:
                readings += self._estimate(frame.stamp_ns or now_ns, frame.data)
        return Step(tuple(readings))

    def lost(self, now_ns: int) -> None:  # noqa: ARG002 - as every device is told
        """The port was lost: nothing is believed until a heartbeat, and the axis may have restarted."""
        self._heartbeat = None
        self._gap = True

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
        if faults := heartbeat.faults():
            return State.FAILED, f"{faults}: clear it at the controller (or is its firmware 0.6?)"
        if heartbeat.state in UNSETTLED:
            return State.FAULTY, f"its position does not count yet: {AxisState(heartbeat.state).name}"
        if self._estimate_ns is None or now_ns - self._estimate_ns > HEARTBEAT_NS:
            return State.STALLED, "heartbeats, but no believable estimates: is encoder_rate_ms set?"
        return State.WELL, "turning counted"

    def _command(self, frame: CanFrame) -> int | None:
        """The command of a well-formed frame from this axis; any other is counted."""
        if frame.extended or frame.remote:
            self._counts["extended or remote frames"] += 1
        elif frame.identifier >> COMMAND_BITS != self._node:
            self._counts["foreign frames"] += 1
        elif (command := frame.identifier & 0x1F) not in (HEARTBEAT, ESTIMATES):
            self._counts["other frames"] += 1
        elif len(frame.data) != LENGTH:
            self._counts["short frames"] += 1
        else:
            return command
        return None

    def _beat(self, stamp_ns: int, heartbeat: Heartbeat) -> None:
        self._counts["heartbeats"] += 1
        self._gap |= not (self._alive(stamp_ns) and heartbeat.trustworthy)
        self._restarted |= heartbeat.state in UNSETTLED and not heartbeat.error
        self._heartbeat = heartbeat
        self._heartbeat_ns = stamp_ns

    def _alive(self, now_ns: int) -> bool:
        return self._heartbeat is not None and now_ns - self._heartbeat_ns <= HEARTBEAT_NS

    def _estimate(self, stamp_ns: int, data: bytes) -> tuple[WheelReading, ...]:
        turns, rate = decode_estimates(data)
        if reason := self._doubt(stamp_ns, turns, rate):
            self._counts[reason] += 1
            return ()
        advance = self._angle.advance(stamp_ns, turns, rate, self._gap, self._restarted)
        if advance is None:
            self._counts["doubtful jumps"] += 1
            return ()
        angle, jumped = advance
        self._turns = turns
        self._gap = self._restarted = False
        self._estimate_ns = stamp_ns
        self._counts["estimates"] += 1
        self._counts["discontinuities"] += jumped
        wheel_rate = self._angle.rate(rate)
        return (WheelReading(stamp_ns, ESTIMATE_ERROR_NS, self.name, angle, wheel_rate, jumped, data),)

    def _doubt(self, stamp_ns: int, turns: float, rate: float) -> str:
        """Why an estimate is not believed; empty if it is."""
        if not self._alive(stamp_ns):
            return "estimates without heartbeat"
        if self._heartbeat is None or not self._heartbeat.trustworthy:
            return "estimates of a faulty or starting axis"
        if not (isfinite(turns) and isfinite(rate)):
            return "estimates not finite"
        if not self._angle.believable(turns, rate):
            return "estimates out of range"
        if not self._angle.precedes(stamp_ns):
            return "estimates out of order"
        if self._suddenly_zero(stamp_ns, turns, rate):
            return "estimates suddenly zero"
        return ""

    def _suddenly_zero(self, stamp_ns: int, turns: float, rate: float) -> bool:
        """Whether it reads like an encoder that failed since the last heartbeat: the next one will tell."""
        if turns or rate or not self._turns:
            self._zeros_ns = None
            return False
        if self._zeros_ns is None:
            self._zeros_ns = stamp_ns
        return self._heartbeat_ns <= self._zeros_ns
