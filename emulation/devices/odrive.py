"""An emulated ODrive axis: a wheel's encoder behind CANSimple, as firmware 0.5 speaks it."""

import struct
from collections.abc import Callable
from dataclasses import dataclass
from math import floor
from random import Random

from echogrid.drivers.bus import NEVER_NS
from echogrid.emulation.devices.cansimple_axis import CansimpleAxis, State, require_node

_COUNTS = 0x00A
_WATCHDOG = 0x800
_MOTOR_FAILED, _ENCODER_FAILED, _TRAJECTORY_DONE = 1 << 40, 1 << 48, 1 << 63
_USUAL_COUNTS = 8192


@dataclass(frozen=True, slots=True)
class ODriveOptions:
    """How the axis is configured."""

    node: int = 0
    gear: float = 1.0
    """Turns of the encoder for one of the wheel; negative if it counts backwards."""
    counts_per_turn: int = 0
    """If it is given, counts are sent by themselves; 0: only on request, 8192 for a turn."""
    heartbeat_ns: int = 100_000_000
    estimates_ns: int = 10_000_000
    counts_ns: int = 10_000_000
    watchdog: bool = False
    """Whether it stops, with an error, when no frame has come for `watchdog_ns`; from the factory not."""
    watchdog_ns: int = 500_000_000

    def __post_init__(self) -> None:
        require_node(self.node)


class ODriveAxis(CansimpleAxis):
    """Firmware 0.5: it tells counts, too, and gives no answer to a request for its version."""

    def __init__(
        self,
        name: str,
        angle: Callable[[int], float],
        random: Random,
        options: ODriveOptions = ODriveOptions(),
    ) -> None:
        super().__init__(name, angle, random, options)
        self._per_turn = options.counts_per_turn or _USUAL_COUNTS
        self._period_ns = options.counts_ns if options.counts_per_turn else NEVER_NS
        self._counts_ns = NEVER_NS

    def _power_up(self, now_ns: int) -> None:
        super()._power_up(now_ns)
        if self._period_ns < NEVER_NS:
            self._counts_ns = now_ns + self._phase_ns

    def _power_down(self) -> None:
        super()._power_down()
        self._counts_ns = NEVER_NS

    def _next_ns(self) -> int:
        return min(super()._next_ns(), self._counts_ns)

    def _step(self, now_ns: int) -> None:
        super()._step(now_ns)
        if now_ns >= self._counts_ns:
            self._send(_COUNTS, self._counts(now_ns), now_ns)
            self._counts_ns += self._period_ns

    def _heartbeat(self, now_ns: int) -> bytes:
        return heartbeat(
            self.state(now_ns),
            encoder_failed="encoder_lost" in self.faults,
            motor_failed="motor_failed" in self.faults,
            error=_WATCHDOG * self._expired,
        )

    def _told(self, command: int, now_ns: int) -> bytes:
        return self._counts(now_ns) if command == _COUNTS else super()._told(command, now_ns)

    def _counts(self, now_ns: int) -> bytes:
        """The encoder counts on whatever the axis does."""
        self._sample(now_ns)
        return counts(floor(self._turns * self._per_turn), self._per_turn)

    def _position_in(self, data: bytes) -> float:
        (count,) = struct.unpack("<i", data)
        return float(count) / self._per_turn


def heartbeat(
    state: State,
    *,
    encoder_failed: bool = False,
    motor_failed: bool = False,
    trajectory_done: bool = False,
    error: int = 0,
) -> bytes:
    """Command 0x001 of firmware 0.5: the axis error, the state, and the flags."""
    flags = _ENCODER_FAILED * encoder_failed | _MOTOR_FAILED * motor_failed
    return (error | state << 32 | flags | _TRAJECTORY_DONE * trajectory_done).to_bytes(8, "little")


def counts(shadow: int, per_turn: int) -> bytes:
    """Command 0x00A: the count since power-up, which wraps at 2^31, and the count within the turn."""
    wrapped = (shadow + (1 << 31)) % (1 << 32) - (1 << 31)
    return struct.pack("<ii", wrapped, shadow % per_turn)
