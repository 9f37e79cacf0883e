"""An emulated ODrive axis, firmware 0.5: a wheel's encoder behind CANSimple."""

import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import IntEnum
from math import floor, tau
from random import Random

from echogrid.drivers.bus import NEVER_NS, CanFrame
from echogrid.emulation.devices.can_node import CanNode
from echogrid.emulation.devices.device import LOOKED_UP
from echogrid.emulation.faults import Verb

_HEARTBEAT = 0x001
_ESTIMATES = 0x009
_COUNTS = 0x00A
_REBOOT = 0x016
_ENCODER_FAILED = 1 << 48
_STARTUP_NS = 200_000_000
"""From power-up to the state STARTUP, and again from there to IDLE: a guess."""


class State(IntEnum):
    """What the axis does, as in its heartbeat."""

    UNDEFINED = 0
    IDLE = 1
    STARTUP = 2
    CLOSED_LOOP = 8


@dataclass(frozen=True, slots=True)
class ODriveOptions:
    """How the axis is configured."""

    node: int = 0
    gear: float = 1.0
    """Turns of the encoder for one of the wheel; negative if it counts backwards."""
    counts_per_turn: int = 8192
    heartbeat_ns: int = 100_000_000
    estimates_ns: int = 10_000_000

    def __post_init__(self) -> None:
        if not 0 <= self.node < 64:
            raise ValueError(f"node {self.node} does not fit a standard identifier (0 to 63)")


class ODriveAxis(CanNode):
    """Sends its heartbeat and its encoder estimates by itself, and answers requests for estimates and counts.

    The position counts from power-up. Until the axis is IDLE, and while the encoder is lost, it is not valid:
    the estimates are then 0.0, as if the wheel stood at its origin.
    """

    def __init__(
        self,
        name: str,
        angle: Callable[[int], float],
        random: Random,
        options: ODriveOptions = ODriveOptions(),
    ) -> None:
        super().__init__(name)
        self._angle = angle
        self._random = random
        self._options = options
        self._phase_ns = random.randrange(options.estimates_ns)
        self._powered_ns = 0
        self._origin = 0.0
        self._sampled_ns = 0
        self._turns = self._velocity = 0.0
        self._heartbeat_ns = self._estimates_ns = NEVER_NS

    def receive(self, frame: CanFrame, now_ns: int) -> None:
        """Answer a request, or obey a reboot."""
        if frame.extended or frame.identifier >> 5 != self._options.node:
            return
        command = frame.identifier & 0x1F
        asked = frame.remote or not frame.data
        if command == _REBOOT:
            self.reboot(now_ns)
        elif asked and command == _ESTIMATES:
            self._send(_ESTIMATES, self._estimates(now_ns), now_ns)
        elif asked and command == _COUNTS:
            self._send(_COUNTS, self._counts(now_ns), now_ns)

    def reboot(self, now_ns: int) -> None:
        """Start up anew: the position begins at 0 where the wheel is."""
        self._power_down()
        self._power_up(now_ns)

    def state(self, now_ns: int) -> State:
        """What the axis does: it starts up for a while before it is IDLE."""
        age_ns = now_ns - self._powered_ns
        if age_ns < _STARTUP_NS:
            return State.UNDEFINED
        return State.STARTUP if age_ns < 2 * _STARTUP_NS else State.IDLE

    def _verbs(self) -> Mapping[str, Verb]:
        return {**super()._verbs(), "encoder_lost": LOOKED_UP}

    def _power_up(self, now_ns: int) -> None:
        self._powered_ns = self._sampled_ns = now_ns
        self._origin = self._angle(now_ns)
        self._turns = self._velocity = 0.0
        self._heartbeat_ns = now_ns
        self._estimates_ns = now_ns + self._phase_ns

    def _power_down(self) -> None:
        self._heartbeat_ns = self._estimates_ns = NEVER_NS
        self.withdraw()

    def _next_ns(self) -> int:
        return min(self._heartbeat_ns, self._estimates_ns)

    def _step(self, now_ns: int) -> None:
        if now_ns >= self._heartbeat_ns:
            lost = "encoder_lost" in self.faults
            self._send(_HEARTBEAT, heartbeat(self.state(now_ns), encoder_failed=lost), now_ns)
            self._heartbeat_ns += self._options.heartbeat_ns
        if now_ns >= self._estimates_ns:
            self._send(_ESTIMATES, self._estimates(now_ns), now_ns)
            self._estimates_ns += self._options.estimates_ns

    def _estimates(self, now_ns: int) -> bytes:
        self._sample(now_ns)
        return estimates(self._turns, self._velocity) if self._valid(now_ns) else estimates(0.0, 0.0)

    def _counts(self, now_ns: int) -> bytes:
        self._sample(now_ns)
        return counts(floor(self._turns * self._options.counts_per_turn), self._options.counts_per_turn)

    def _sample(self, now_ns: int) -> None:
        """Look at the encoder; the velocity is the mean since the last look."""
        if now_ns <= self._sampled_ns:
            return
        turns = (self._angle(now_ns) - self._origin) / tau * self._options.gear
        self._velocity = (turns - self._turns) / (now_ns - self._sampled_ns) * 1e9
        self._turns, self._sampled_ns = turns, now_ns

    def _valid(self, now_ns: int) -> bool:
        return self.state(now_ns) == State.IDLE and "encoder_lost" not in self.faults

    def _send(self, command: int, payload: bytes, now_ns: int) -> None:
        if "garbage" in self.faults:
            payload = self._random.randbytes(len(payload))
        self.post(CanFrame(self._options.node << 5 | command, payload), now_ns + self._delay_ns())


def heartbeat(state: State, *, encoder_failed: bool = False, trajectory_done: bool = False) -> bytes:
    """Command 0x001: no axis error, the state, and the flags."""
    flags = _ENCODER_FAILED * encoder_failed | 1 << 63 & -trajectory_done
    return (state << 32 | flags).to_bytes(8, "little")


def estimates(turns: float, velocity: float) -> bytes:
    """Command 0x009: position (rev) and velocity (rev/s)."""
    return struct.pack("<ff", turns, velocity)


def counts(shadow: int, per_turn: int) -> bytes:
    """Command 0x00A: the count since power-up, which wraps at 2^31, and the count within the turn."""
    wrapped = (shadow + (1 << 31)) % (1 << 32) - (1 << 31)
    return struct.pack("<ii", wrapped, shadow % per_turn)
