"""RCWL-9600 and RCWL-9620 on I2C (M5Stack, Grove): fired by a byte, read as three, in micrometres."""

from dataclasses import dataclass

from echogrid.drivers.bus import I2cTransfer
from echogrid.drivers.course import Course
from echogrid.drivers.i2c_chip import require_address
from echogrid.drivers.i2c_ranger import I2cRanger
from echogrid.drivers.limits import require_between
from echogrid.drivers.make import MILLISECOND_NS, Answer, Trouble
from echogrid.drivers.one_message import OneMessageMake
from echogrid.drivers.role import RangerRole

FIRE = b"\x01"
NO_ECHO_UM = 4_500_000
"""What it says when it hears nothing, and when it is read too early."""
HIGHEST_UM = 5_000_000
"""More is noise on the bus: a tenth beyond its reach."""
NEAREST = 0.02
"""m."""
PING_NS = 120 * MILLISECOND_NS
"""With the data sheet's 100 ms users read too early."""
PATIENCE_NS = 40 * MILLISECOND_NS
REST_NS = 148 * MILLISECOND_NS
"""The 150 ms from ping to ping of M5Stack's own library, less the lateness of a turn."""
RESOLUTION_NS = 1_000
OWN_SPEED = 343.0
"""m/s: with it M5Stack's library makes lengths of the same chip's pulses."""


def micrometres(data: bytes) -> int:
    """The range of the last ping."""
    return int.from_bytes(data[:3], "big")


class Rcwl9620Make(OneMessageMake):
    """The RCWL-9620's messages."""

    ping_ns = PING_NS
    patience_ns = PATIENCE_NS
    rest_ns = REST_NS

    def __init__(self, role: RangerRole, settings: "Rcwl9620.Settings") -> None:
        super().__init__(settings.address, FIRE, RESOLUTION_NS)
        require_between("max_m", role.farthest, 0.0, NO_ECHO_UM * 1e-6)
        self._scale = 1e-6 * role.speed_of_sound / settings.speed_of_sound_m_s

    def set_up(self) -> Course[I2cTransfer, Trouble | None]:
        """Look whether it is there; what it says of an earlier ping is thrown away."""
        return None if (yield from self._chip.insisting.take(3)) else self._chip.missing()

    def collect(self) -> Course[I2cTransfer, bytes]:
        """The range; nothing if it does not acknowledge."""
        return (yield from self._chip.take(3))

    def answer(self, data: bytes) -> Answer:
        """What the range means."""
        value = micrometres(data)
        if not 0 < value <= HIGHEST_UM:
            return Answer(doubt=f"{value} um is no range (1 to {HIGHEST_UM})", gone=False)
        if value >= NO_ECHO_UM:
            return Answer()
        return Answer((value * self._scale,), nearest=NEAREST)


class Rcwl9620(I2cRanger):
    """One RCWL-9600 or RCWL-9620."""

    @dataclass(frozen=True, slots=True)
    class Settings:
        """Its keys in a config file."""

        address: int = 0x57
        """7 bit."""
        speed_of_sound_m_s: float = OWN_SPEED
        """With which it makes lengths of times."""

        def __post_init__(self) -> None:
            require_address(self.address)
            require_between("speed_of_sound_m_s", self.speed_of_sound_m_s, 300.0, 400.0)

    def __init__(self, role: RangerRole, settings: Settings) -> None:
        super().__init__(role, Rcwl9620Make(role, settings))
