"""What SRF08 and SRF10 share beyond their kin: a gain, and a range which says for how long they listen."""

from collections.abc import Sequence
from math import ceil, floor

from echogrid.drivers.bus import I2cTransfer
from echogrid.drivers.course import Course
from echogrid.drivers.devantech import (
    GAIN,
    GATE_SPEED,
    MICROSECONDS,
    OVERHEAD_NS,
    RANGE,
    REVISION,
    DevantechMake,
    words,
)
from echogrid.drivers.device import State
from echogrid.drivers.make import MILLISECOND_NS, Answer
from echogrid.drivers.role import RangerRole

GATE_STEPS = 256
GATE_STEP = 0.043
"""m of reach for each step of the range register."""
LOOK_NS = 2 * MILLISECOND_NS
"""So long before the earliest end of a ping it is looked at: two messages take half of that."""
SET_ANEW = 16
"""Of so many answers the last is followed by the settings: 0.6 ms on the bus, and nothing that wears out."""


def range_register(farthest: float, speed_of_sound: float) -> int:
    """The least value with which the chip listens until an echo from `farthest` (m) is back.

    Raises ValueError if there is none.
    """
    step = GATE_STEP * speed_of_sound / GATE_SPEED
    steps = max(ceil(farthest / step), 1)
    if farthest < 0.0 or steps > GATE_STEPS:
        reach = floor(100 * GATE_STEPS * step) / 100
        raise ValueError(f"max_m is {farthest}: expected 0.0 to {reach}")
    return steps - 1


def gate_us(register: int) -> float:
    """How long the chip listens."""
    return (register + 1) * GATE_STEP * 2e6 / GATE_SPEED


def echoes_us(registers: bytes) -> tuple[int, ...]:
    """Times of flight in the registers from 0 on, nearest first; a zero ends the list."""
    times = words(registers[2:])
    return times[: times.index(0)] if 0 in times else times


class GatedMake(DevantechMake):
    """One with a gain and a range to be set, which tells times of flight, one or several.

    Neither can be read back. Another program which sets it up for itself makes it listen for less, and hear
    nothing of what is farther away: it is looked at once in each ping, whether it has done too soon, and its
    settings are written again and again, for what is too little to be seen by that.
    """

    def __init__(self, role: RangerRole, address: int, gain: int, echoes: int) -> None:
        super().__init__(role, address, 2 + 2 * echoes)
        register = range_register(role.farthest, role.speed_of_sound)
        self._settings = ((GAIN, gain), (RANGE, register))
        self._gate_us = gate_us(register)
        self._least_ns = round((0.9 * self._gate_us - 500) * 1e3)
        self._early_ns = self._answers = 0
        self.ping_ns = round(self._gate_us * 1e3) + OVERHEAD_NS

    def meanwhile(self) -> Course[I2cTransfer, None]:
        """Look at it when it can't have done yet, unless its pings are too short for that."""
        self._early_ns = 0
        if self._least_ns < LOOK_NS:
            return
        yield self._fired_ns + self._least_ns - LOOK_NS
        pointed = yield from self._chip.write(REVISION)
        if pointed.errno:
            return
        seen = yield from self._chip.receive(self.fixed)
        passed_ns = seen.end_ns - self._fired_ns
        if not seen.errno and seen.data == self._identity and passed_ns < self._least_ns:
            self._early_ns = passed_ns

    def collect(self) -> Course[I2cTransfer, bytes]:
        """The registers; nothing while it pings."""
        registers = yield from super().collect()
        if registers:
            self._answers += 1
            if self._answers % SET_ANEW == 0:
                yield from self._set()
        return registers

    def answer(self, data: bytes) -> Answer:
        """What the registers mean."""
        return self._early() or super().answer(data)

    def _command(self, listens: bool) -> int:
        """It can't listen without a ping."""
        del listens
        return MICROSECONDS

    def _early(self) -> Answer | None:
        """The doubt whether it listened for as long as it was told to."""
        if not self._early_ns:
            return None
        expected_ms, early_ms = self.ping_ns // MILLISECOND_NS, self._early_ns // MILLISECOND_NS
        why = "did another program set it up, or is it an SRF235?"
        return Answer(doubt=f"ready within {early_ms} ms, not {expected_ms}: {why}")

    def _heard(self, data: bytes) -> Answer:
        times = echoes_us(data)
        if list(times) != sorted(times):
            said = f"echoes after {_listed(times)} us are out of order"
            return Answer(doubt=f"{said}: two devices at one address?", state=State.CONFLICT)
        if times and times[-1] > 1.1 * self._gate_us + 500:
            return Answer(doubt=f"{times[-1]} us is longer than it listened")
        return Answer(tuple(self._metres(time) for time in times))


def _listed(times: Sequence[int]) -> str:
    return ", ".join(str(time) for time in times)
