"""Devantech SRF235: a ranger on I2C with a 235 kHz pencil beam, quick and short of range.

A smooth surface more than 8 or 9 degrees off the square sends the beam elsewhere, and soft ones swallow it:
that it hears nothing does not mean that nothing is there.
"""

from dataclasses import dataclass

from echogrid.drivers.devantech import (
    FIRST_ADDRESS,
    GATE_SPEED,
    MICROSECONDS,
    DevantechMake,
    require_address,
    words,
)
from echogrid.drivers.i2c_ranger import I2cRanger
from echogrid.drivers.limits import require_between
from echogrid.drivers.make import MILLISECOND_NS, Answer
from echogrid.drivers.role import RangerRole

OWN_UNIT = 0x51
"""The command for a ping in the unit on which sources differ."""
NEAREST_US, FARTHEST_US = 300, 11_000
"""5 cm and 1.9 m: it is deaf up to 10 cm, and listens for 10 ms."""
PING_NS = 10 * MILLISECOND_NS
FARTHEST = 1.2
"""m, of its data sheet."""


class Srf235Make(DevantechMake):
    """The SRF235's messages: nothing can be set."""

    name = "SRF235"
    kin = "SRF02, SRF08 or SRF10"
    ping_ns = PING_NS
    rest_ns = PING_NS

    def __init__(self, role: RangerRole, settings: "Srf235.Settings") -> None:
        super().__init__(role, settings.address, registers=4)
        require_between("max_m", role.farthest, 0.0, FARTHEST)
        self._ping_command = settings.command
        metres = settings.unit_mm / 1000
        self._unit_us = 1.0 if settings.command == MICROSECONDS else 2e6 * metres / GATE_SPEED

    def _command(self, listens: bool) -> int:
        """It can't listen without a ping."""
        del listens
        return self._ping_command

    def _fits(self, register: int) -> bool:
        """The data sheet does not say what its unused register reads."""
        del register
        return True

    def _heard(self, data: bytes) -> Answer:
        """A range which it can't have is told in another unit than was believed."""
        (count,) = words(data[2:4])
        time_us = count * self._unit_us
        if count and not NEAREST_US <= time_us <= FARTHEST_US:
            said = f"{count} units are {self._metres(time_us):.3f} m, which it can't range"
            return Answer(doubt=f"{said}: check unit_mm and command", gone=False)
        return Answer((self._metres(time_us),) if count else ())


class Srf235(I2cRanger):
    """One SRF235."""

    @dataclass(frozen=True, slots=True)
    class Settings:
        """Its keys in a config file."""

        address: int = FIRST_ADDRESS
        """7 bit."""
        command: int = OWN_UNIT
        """What starts a ping: 0x51, or 0x52 for microseconds, which it may not know."""
        unit_mm: float = 10.0
        """The unit of its answer to 0x51: centimetres or millimetres."""

        def __post_init__(self) -> None:
            require_address(self.address)
            require_between("command", self.command, OWN_UNIT, MICROSECONDS)
            require_between("unit_mm", self.unit_mm, 1.0, 10.0)

    def __init__(self, role: RangerRole, settings: Settings) -> None:
        super().__init__(role, Srf235Make(role, settings))
