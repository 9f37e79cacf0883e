"""Devantech SRF02 on I2C: one capsule for both ways, whose dead zone shrinks in its first pings."""

from dataclasses import dataclass
from typing import ClassVar

from echogrid.drivers.devantech import (
    FIRST_ADDRESS,
    FULL_PING_NS,
    MICROSECONDS,
    OVERHEAD_NS,
    DevantechMake,
    require_address,
    words,
)
from echogrid.drivers.device import State
from echogrid.drivers.i2c_ranger import I2cRanger
from echogrid.drivers.limits import require_between
from echogrid.drivers.make import MILLISECOND_NS, Answer
from echogrid.drivers.role import RangerRole

LISTEN_MICROSECONDS = 0x58
"""The "fake" ranging: all of it but the ping."""
REGISTERS = 6
"""Revision, nothing, range and minimum, both high byte first and in the unit of the command."""
MINIMA_US = 290, 2_900
"""5 to 50 cm: they begin at 28 cm and come down to 11 to 16, a little more in the heat."""
REST_NS = 68 * MILLISECOND_NS
"""The maker's 70 ms after which it is always ready, less the lateness of a turn."""


class Srf02Make(DevantechMake):
    """The SRF02's messages: nothing can be set."""

    can_listen: ClassVar[bool] = True

    name = "SRF02"
    ping_ns = FULL_PING_NS + OVERHEAD_NS
    patience_ns = 30 * MILLISECOND_NS
    rest_ns = REST_NS

    def __init__(self, role: RangerRole, settings: "Srf02.Settings") -> None:
        super().__init__(role, settings.address, REGISTERS)
        require_between("max_m", role.farthest, 0.0, round(self._metres(FULL_PING_NS / 1e3), 2))

    def _command(self, listens: bool) -> int:
        return LISTEN_MICROSECONDS if listens else MICROSECONDS

    def _heard(self, data: bytes) -> Answer:
        """What it hears in the moment when it ceases to be deaf may have begun before, nearer by."""
        flight, minimum = words(data[2:])
        if not MINIMA_US[0] <= minimum <= MINIMA_US[1]:
            said = f"a minimum of {minimum} us is no SRF02's"
            return Answer(doubt=f"{said}: is it an SRF10, or are there two?", state=State.WRONG_DEVICE)
        return Answer((self._metres(flight),) if flight else (), nearest=self._metres(minimum + 1))


class Srf02(I2cRanger):
    """One SRF02 in its I2C mode."""

    @dataclass(frozen=True, slots=True)
    class Settings:
        """Its keys in a config file."""

        address: int = FIRST_ADDRESS
        """7 bit."""

        def __post_init__(self) -> None:
            require_address(self.address)

    def __init__(self, role: RangerRole, settings: Settings) -> None:
        super().__init__(role, Srf02Make(role, settings))
