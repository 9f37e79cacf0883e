"""An emulated yaw gyro behind a microcontroller that prints a line for each rate."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from random import Random

from echogrid.drivers.bus import NEVER_NS
from echogrid.emulation.devices.rate_sensor import GYRO_VERBS, GyroOptions, RateSensor
from echogrid.emulation.devices.serial_device import SerialDevice
from echogrid.emulation.faults import Verb

_STARTUP_NS = 200_000_000
"""From power-up until it prints: a guess."""


@dataclass(frozen=True, slots=True)
class GyroTextOptions(GyroOptions):
    """How its lines look."""

    baud: int = 115_200
    separator: str = ","
    column: int = 1
    """Counted from 1; in those before it there is a 0."""
    key: str = ""
    """What stands before the number."""

    def line(self, number: float) -> bytes:
        """The line of a number."""
        columns = ["0"] * (self.column - 1) + [f"{self.key}{number:.6g}"]
        return f"{self.separator.join(columns)}\r\n".encode()


class GyroText(SerialDevice):
    """Prints a line every period, in a phase of its own from its start."""

    def __init__(
        self,
        name: str,
        yaw_rate: Callable[[int], float],
        random: Random,
        options: GyroTextOptions = GyroTextOptions(),
    ) -> None:
        super().__init__(name, options.baud)
        self._sensor = RateSensor(yaw_rate, self.faults, random, options)
        self._options = options
        self._phase_ns = random.randrange(options.period_ns)
        self._due_ns = NEVER_NS

    def receive(self, data: bytes, now_ns: int) -> None:
        """Nothing: it takes no commands."""

    def _verbs(self) -> Mapping[str, Verb]:
        return {**super()._verbs(), **GYRO_VERBS}

    def _power_up(self, now_ns: int) -> None:
        self._due_ns = now_ns + _STARTUP_NS + self._phase_ns

    def _power_down(self) -> None:
        self._due_ns = NEVER_NS
        self.output.stop()

    def _next_ns(self) -> int:
        return self._due_ns

    def _step(self, now_ns: int) -> None:
        if now_ns >= self._due_ns:
            line = self._options.line(self._sensor.number(now_ns))
            if "garbage" in self.faults:
                line = self._sensor.random.randbytes(len(line))
            self.send(line, now_ns + self._delay_ns())
            self._due_ns += self._options.period_ns
