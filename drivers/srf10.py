"""Devantech SRF10: the smallest ranger on I2C; an SRF08 with one echo, other gains and no light sensor."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from echogrid.drivers.bus import I2cResult, I2cTransfer
from echogrid.drivers.commanded import CommandedRanger
from echogrid.drivers.devantech import FIRST_ADDRESS, LAST_ADDRESS, GatedMake
from echogrid.drivers.device import Line
from echogrid.drivers.limits import require_between
from echogrid.drivers.role import RangerRole

HIGHEST_GAIN = 16


class Srf10Make(GatedMake):
    """The SRF10's messages."""

    name = "SRF10"
    kin = "SRF02"

    def __init__(self, role: RangerRole, settings: "Srf10.Settings") -> None:
        super().__init__(role, settings.address, settings.gain, echoes=1)


class Srf10(CommandedRanger[I2cTransfer]):
    """One SRF10."""

    bus: ClassVar[str] = "i2c"
    line: ClassVar[type[Line[I2cResult, I2cTransfer]]] = Line
    identity: ClassVar[str] = "address"
    port_options: ClassVar[Mapping[str, object]] = {}

    @dataclass(frozen=True, slots=True)
    class Settings:
        """Its keys in a config file."""

        address: int = FIRST_ADDRESS
        """7 bit."""
        gain: int = HIGHEST_GAIN
        """The step at which its rising amplification stops."""

        def __post_init__(self) -> None:
            require_between("address", self.address, FIRST_ADDRESS, LAST_ADDRESS)
            require_between("gain", self.gain, 0, HIGHEST_GAIN)

    def __init__(self, role: RangerRole, settings: Settings) -> None:
        super().__init__(role, Srf10Make(role, settings))
