"""An emulated Devantech SRF08: ranging on command, seventeen echoes, silent while it listens."""

from collections.abc import Sequence
from dataclasses import dataclass
from random import Random

from echogrid.emulation.devices.devantech import OWN_SPEED, GatedChip, require_address
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.scene import Echo


@dataclass(frozen=True, slots=True)
class Srf08Options:
    """What differs between chips of this kind."""

    address: int = 0x70
    """7 bit; as it is delivered."""
    revision: int = 10
    light: int = 90
    speed_of_sound: float = OWN_SPEED
    """m/s, which the chip takes for centimetres, inches and its range gate at any temperature."""

    def __post_init__(self) -> None:
        require_address(self.address)


class Srf08Chip(GatedChip):
    """Takes the general call. Its light sensor reads the same at every ping."""

    takes_general_call = True
    gains = (
        *(94, 97, 100, 103, 107, 110, 114, 118, 123, 128, 133, 139, 145, 152, 159, 168),
        *(177, 187, 199, 212, 227, 245, 265, 288, 317, 352, 395, 450, 524, 626, 777, 1025),
    )
    blanking = 0.03
    most_echoes = 17

    def __init__(
        self,
        name: str,
        surroundings: Surroundings,
        random: Random,
        options: Srf08Options = Srf08Options(),
    ) -> None:
        super().__init__(name, options.address, surroundings, random, options.speed_of_sound)
        self._options = options

    def _bank(self) -> bytes:
        return bytes((self._options.revision, self._light)) + self._echoes

    def _forget(self) -> None:
        super()._forget()
        self._light = 0

    def _hear(self, echoes: Sequence[Echo]) -> None:
        super()._hear(echoes)
        self._light = self._options.light
