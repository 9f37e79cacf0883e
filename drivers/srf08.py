"""Devantech SRF08: a ranger on I2C which pings when it is told to, and tells up to seventeen echoes."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from echogrid.drivers.bus import I2cResult, I2cTransfer, Result
from echogrid.drivers.commanded import CommandedRanger
from echogrid.drivers.course import Course
from echogrid.drivers.devantech import (
    COMMAND,
    FIRST_ADDRESS,
    LAST_ADDRESS,
    MICROSECONDS,
    RESOLUTION_NS,
    UNUSED,
    GatedMake,
)
from echogrid.drivers.device import Line
from echogrid.drivers.i2c_chip import GENERAL_CALL, fired, overheard
from echogrid.drivers.limits import require_between
from echogrid.drivers.make import Fired
from echogrid.drivers.role import RangerRole

BRIGHTEST = 248
"""The most that the light sensor in register 1 reads."""
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
        return register <= BRIGHTEST

    def _may_be_kin(self, register: int) -> bool:
        return register == UNUSED


class Srf08(CommandedRanger[I2cTransfer]):
    """One SRF08."""

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
        echoes: int = 1
        """How many are read of each ping: the second and later ones cost 0.2 ms each on the bus."""

        def __post_init__(self) -> None:
            require_between("address", self.address, FIRST_ADDRESS, LAST_ADDRESS)
            require_between("gain", self.gain, 0, HIGHEST_GAIN)
            require_between("echoes", self.echoes, 1, MOST_ECHOES)

    def __init__(self, role: RangerRole, settings: Settings) -> None:
        super().__init__(role, Srf08Make(role, settings))
