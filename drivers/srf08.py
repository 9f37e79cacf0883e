"""Devantech SRF08: a ranger on I2C which pings when it is told to, and tells up to seventeen echoes."""

from dataclasses import dataclass
from typing import ClassVar

from echogrid.drivers.bus import I2cTransfer, Result
from echogrid.drivers.course import Course
from echogrid.drivers.devantech import (
    COMMAND,
    FIRST_ADDRESS,
    MICROSECONDS,
    RESOLUTION_NS,
    UNUSED,
    require_address,
)
from echogrid.drivers.devantech_gated import GatedMake
from echogrid.drivers.i2c_chip import GENERAL_CALL, fired, overheard
from echogrid.drivers.i2c_ranger import I2cRanger
from echogrid.drivers.limits import require_between
from echogrid.drivers.make import Fired
from echogrid.drivers.role import RangerRole

HIGHEST_GAIN = 31
MOST_ECHOES = 17


class Srf08Make(GatedMake):
    """The SRF08's messages. One general call fires all of them on a bus."""

    obeys_general_call: ClassVar[bool] = True

    name = "SRF08"
    fixed = 1
    kin = "SRF02"

    def __init__(self, role: RangerRole, settings: "Srf08.Settings") -> None:
        super().__init__(role, settings.address, settings.gain, settings.echoes)

    def fire_all(self) -> Course[I2cTransfer, Fired]:
        """Start a ping of every SRF08 on the bus."""
        return self._begun(fired((yield from GENERAL_CALL.write(COMMAND, MICROSECONDS)), RESOLUTION_NS))

    def called(self, result: Result[I2cTransfer]) -> Fired | None:
        """The ping that another one started."""
        ping = overheard(result, bytes((COMMAND, MICROSECONDS)), RESOLUTION_NS)
        return ping and self._begun(ping)

    def _fits(self, register: int) -> bool:
        """Any light may be; one of its kin shows by how long it pings."""
        del register
        return True

    def _may_be_kin(self, register: int) -> bool:
        return register == UNUSED


class Srf08(I2cRanger):
    """One SRF08."""

    @dataclass(frozen=True, slots=True)
    class Settings:
        """Its keys in a config file."""

        address: int = FIRST_ADDRESS
        """7 bit."""
        gain: int = HIGHEST_GAIN
        """The step at which its rising amplification stops."""
        echoes: int = 1
        """How many are read of each ping: the second and later ones cost 0.2 ms each on the bus."""

        def __post_init__(self) -> None:
            require_address(self.address)
            require_between("gain", self.gain, 0, HIGHEST_GAIN)
            require_between("echoes", self.echoes, 1, MOST_ECHOES)

    def __init__(self, role: RangerRole, settings: Settings) -> None:
        super().__init__(role, Srf08Make(role, settings))
