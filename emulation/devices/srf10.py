"""An emulated Devantech SRF10: the smallest; an SRF08 with one echo, other gains and no light sensor."""

from dataclasses import dataclass
from random import Random

from echogrid.emulation.devices.devantech import OWN_SPEED, UNUSED, GatedChip, require_address
from echogrid.emulation.devices.surroundings import Surroundings


@dataclass(frozen=True, slots=True)
class Srf10Options:
    """What differs between chips of this kind."""

    address: int = 0x70
    """7 bit; as it is delivered."""
    revision: int = 7
    speed_of_sound: float = OWN_SPEED
    """m/s, which the chip takes for centimetres, inches and its range gate at any temperature."""

    def __post_init__(self) -> None:
        require_address(self.address)


class Srf10Chip(GatedChip):
    """Four registers. Its gain is taken to rise as fast as the SRF08's."""

    gains = (40, 40, 50, 60, 70, 80, 100, 120, 140, 200, 250, 300, 350, 400, 500, 600, 700)
    blanking = 0.06
    most_echoes = 1

    def __init__(
        self,
        name: str,
        surroundings: Surroundings,
        random: Random,
        options: Srf10Options = Srf10Options(),
    ) -> None:
        super().__init__(name, options.address, surroundings, random, options.speed_of_sound)
        self._options = options

    def _bank(self) -> bytes:
        return bytes((self._options.revision, UNUSED)) + self._echoes
