"""An emulated yaw gyro that sends its rate in a CAN frame."""

import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from random import Random

from echogrid.drivers.bus import NEVER_NS, CanFrame
from echogrid.emulation.devices.can_node import CanNode
from echogrid.emulation.devices.rate_sensor import GYRO_VERBS, GyroOptions, RateSensor
from echogrid.emulation.faults import Verb

_STARTUP_NS = 200_000_000
"""From power-up until it sends: a guess."""
_MOST = 32_767


@dataclass(frozen=True, slots=True)
class GyroDbcOptions(GyroOptions):
    """Its frame: the rate in 16 bits with a sign, little-endian, in steps of so much of `unit`; then a count
    of the frames, 8 bits, and a byte of zero."""

    identifier: int = 0x1A0
    """Of 11 bits; above that of 29."""
    step: float = 0.01

    def __post_init__(self) -> None:
        GyroOptions.__post_init__(self)
        if not 0 <= self.identifier < 1 << 29:
            raise ValueError(f"identifier {self.identifier:#x} does not fit 29 bits")
        if not self.step > 0.0:
            raise ValueError(f"step {self.step}: it must be above 0")

    def frame(self, number: float, count: int) -> CanFrame:
        """The frame of a number; what does not fit is the nearest that does."""
        steps = max(-_MOST, min(_MOST, round(number / self.step)))
        data = struct.pack("<hBB", steps, count % 256, 0)
        return CanFrame(self.identifier, data, extended=self.identifier > 0x7FF)


class GyroDbc(CanNode):
    """Sends a frame every period, in a phase of its own from its start."""

    def __init__(
        self,
        name: str,
        yaw_rate: Callable[[int], float],
        random: Random,
        options: GyroDbcOptions = GyroDbcOptions(),
    ) -> None:
        super().__init__(name)
        self._sensor = RateSensor(yaw_rate, self.faults, random, options)
        self._options = options
        self._phase_ns = random.randrange(options.period_ns)
        self._due_ns = NEVER_NS
        self._sent = 0

    def receive(self, frame: CanFrame, now_ns: int) -> None:
        """Nothing: it takes no commands."""

    def _verbs(self) -> Mapping[str, Verb]:
        return {**super()._verbs(), **GYRO_VERBS}

    def _power_up(self, now_ns: int) -> None:
        self._due_ns = now_ns + _STARTUP_NS + self._phase_ns
        self._sent = 0

    def _power_down(self) -> None:
        self._due_ns = NEVER_NS
        self.withdraw()

    def _next_ns(self) -> int:
        return self._due_ns

    def _step(self, now_ns: int) -> None:
        if now_ns >= self._due_ns:
            frame = self._options.frame(self._sensor.number(now_ns), self._sent)
            if "garbage" in self.faults:
                noise = self._sensor.random.randbytes(len(frame.data))
                frame = CanFrame(frame.identifier, noise, extended=frame.extended)
            self.post(frame, now_ns + self._delay_ns())
            self._sent += 1
            self._due_ns += self._options.period_ns
