"""An emulated RCWL-9620 (RCWL-9600) on I2C: a byte fires it, three bytes are the range in micrometres."""

from collections.abc import Sequence
from dataclasses import dataclass
from random import Random
from typing import ClassVar

from echogrid.drivers.bus import NEVER_NS
from echogrid.emulation.devices.i2c_ranger import I2cRanger
from echogrid.emulation.devices.sonar import first_heard
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.scene import Echo

_RANGE = 0x01
_NEAREST_UM = 20_000
_NOTHING_UM = 4_500_000
_RANGING_NS = 110_000_000
"""After the 100 ms of its data sheet users still read too early, after 120 ms not."""


@dataclass(frozen=True, slots=True)
class Rcwl9620Options:
    """What differs between parts."""

    address: int = 0x57
    """7 bit."""
    speed_of_sound: float = 343.0
    """m/s, which it takes for its micrometres at any temperature."""

    def __post_init__(self) -> None:
        if not 0x08 <= self.address <= 0x77:
            raise ValueError(f"address {self.address:#x} is not one of a chip (0x08 to 0x77, 7 bit)")


class Rcwl9620Chip(I2cRanger):
    """Acknowledges at any time; until it has ranged it says the same as when it heard nothing.

    Commands that come meanwhile are passed over. Nearer than 2 cm it says 2 cm.
    """

    mute_while_ranging: ClassVar[bool] = False

    def __init__(
        self,
        name: str,
        surroundings: Surroundings,
        random: Random,
        options: Rcwl9620Options = Rcwl9620Options(),
    ) -> None:
        super().__init__(name, options.address, surroundings, random)
        self._options = options
        self._forget()

    def write(self, data: bytes, now_ns: int) -> None:
        """The command to range."""
        if data[:1] == bytes((_RANGE,)) and not self.ranging(now_ns):
            self._micrometres = _NOTHING_UM
            self._begin(now_ns, _RANGING_NS, NEVER_NS)

    def _registers(self, count: int) -> bytes:
        """The range; nobody drives the bus after it."""
        return self._micrometres.to_bytes(3, "big")[:count].ljust(count, b"\xff")

    def _forget(self) -> None:
        self._micrometres = _NOTHING_UM

    def _hear(self, echoes: Sequence[Echo]) -> None:
        distance = first_heard(echoes, _NOTHING_UM * 1e-6)
        if distance is not None:
            own = round(1e6 * distance * self._options.speed_of_sound / self.sonar.speed_of_sound)
            self._micrometres = min(max(own, _NEAREST_UM), _NOTHING_UM)
