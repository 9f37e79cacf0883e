"""Devantech SRF10: the smallest ranger on I2C; an SRF08 with one echo, other gains and no light sensor."""

from dataclasses import dataclass

from echogrid.drivers.devantech import FIRST_ADDRESS, require_address
from echogrid.drivers.devantech_gated import GatedMake
from echogrid.drivers.i2c_ranger import I2cRanger
from echogrid.drivers.limits import require_between
from echogrid.drivers.role import RangerRole

HIGHEST_GAIN = 16


class Srf10Make(GatedMake):
    """The SRF10's messages."""

    name = "SRF10"
    kin = "SRF02"

    def __init__(self, role: RangerRole, settings: "Srf10.Settings") -> None:
        super().__init__(role, settings.address, settings.gain, echoes=1)


class Srf10(I2cRanger):
    """One SRF10."""

    @dataclass(frozen=True, slots=True)
    class Settings:
        """Its keys in a config file."""

        address: int = FIRST_ADDRESS
        """7 bit."""
        gain: int = HIGHEST_GAIN
        """The step at which its rising amplification stops."""

        def __post_init__(self) -> None:
            require_address(self.address)
            require_between("gain", self.gain, 0, HIGHEST_GAIN)

    def __init__(self, role: RangerRole, settings: Settings) -> None:
        super().__init__(role, Srf10Make(role, settings))
