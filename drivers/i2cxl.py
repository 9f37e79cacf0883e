"""MaxBotix I2CXL-MaxSonar: a ranger on I2C without registers, fired by a byte and read as two."""

from dataclasses import dataclass

from echogrid.drivers.bus import I2cTransfer
from echogrid.drivers.course import Course
from echogrid.drivers.i2c_chip import require_address
from echogrid.drivers.i2c_ranger import I2cRanger
from echogrid.drivers.limits import require_between
from echogrid.drivers.make import MILLISECOND_NS, Answer, Trouble
from echogrid.drivers.one_message import OneMessageMake
from echogrid.drivers.role import RangerRole

FIRE = b"\x51"
UNLOCK = b"\xaa\xa5"
"""What a new address must follow in the same message."""
REFUSED = frozenset({0x00, 0x50, 0xA4, 0xAA})
"""8-bit addresses that it stays away from, silently."""

FARTHEST_CM = 765
PING_NS = 80 * MILLISECOND_NS
"""The data sheet's pause between the command and the reading."""
PATIENCE_NS = 40 * MILLISECOND_NS
REST_NS = 98 * MILLISECOND_NS
"""The data sheet's 100 ms between pings, less the lateness of a turn."""
RESOLUTION_NS = 29_000
"""Sound goes a centimetre in that time."""
OWN_SPEED = 344.8
"""m/s: the XL-MaxSonars count 58 us a centimetre, there and back."""


def address_change(address: int) -> bytes:
    """The message that moves the ranger which hears it to another address (7 bit), for good.

    Raises ValueError for one that it would refuse without a word.
    """
    require_address(address)
    if 2 * address in REFUSED:
        raise ValueError(f"an I2CXL refuses the address {address:#04x} (7 bit): choose another")
    return UNLOCK + bytes((2 * address,))


def centimetres(data: bytes) -> int:
    """The range of the last ping; below zero it is an error."""
    return int.from_bytes(data[:2], "big", signed=True)


class I2cxlMake(OneMessageMake):
    """The I2CXL's messages. It takes no part in the bus while it ranges."""

    ping_ns = PING_NS
    patience_ns = PATIENCE_NS
    rest_ns = REST_NS

    def __init__(self, role: RangerRole, settings: "I2cxl.Settings") -> None:
        super().__init__(settings.address, FIRE, RESOLUTION_NS)
        require_between("max_m", role.farthest, 0.0, FARTHEST_CM / 100)
        self._settings = settings
        own_speed = settings.speed_of_sound_m_s or role.speed_of_sound
        self._metres = 0.01 * role.speed_of_sound / own_speed
        self._nearest = (settings.minimum_cm + 0.5) * self._metres

    def set_up(self) -> Course[I2cTransfer, Trouble | None]:
        """Look whether it is there; what it says is thrown away.

        A reading is the only message of the data sheet that changes nothing. After power-up it brings
        two bytes of part information, which look like a range.
        """
        return None if (yield from self._chip.insisting.take(2)) else self._chip.missing()

    def collect(self) -> Course[I2cTransfer, bytes]:
        """The range; nothing while it ranges."""
        return (yield from self._chip.take(2))

    def answer(self, data: bytes) -> Answer:
        """What the range means: the least that it can tell means "as near as that, or nearer"."""
        value = centimetres(data)
        if value == self._settings.no_echo_cm:
            return Answer()
        if not 0 < value <= FARTHEST_CM:
            doubt = f"it says {data.hex(' ')}, which is no range (1 to {FARTHEST_CM} cm)"
            return Answer(doubt=doubt, gone=False)
        return Answer((value * self._metres,), nearest=self._nearest)


class I2cxl(I2cRanger):
    """One I2CXL-MaxSonar."""

    @dataclass(frozen=True, slots=True)
    class Settings:
        """Its keys in a config file."""

        address: int = 0x70
        """7 bit."""
        minimum_cm: int = 20
        """What it says of all that is nearer: 20 or 25 by the part."""
        no_echo_cm: int = FARTHEST_CM
        """What it says when it hears nothing."""
        speed_of_sound_m_s: float = OWN_SPEED
        """With which it makes centimetres of times; 0: it measures the temperature, and they are true."""

        def __post_init__(self) -> None:
            require_address(self.address, highest=0x7F)
            require_between("minimum_cm", self.minimum_cm, 1, 100)
            require_between("no_echo_cm", self.no_echo_cm, 0, 0x7FFF)
            if self.speed_of_sound_m_s:
                require_between("speed_of_sound_m_s", self.speed_of_sound_m_s, 300.0, 400.0)

    def __init__(self, role: RangerRole, settings: Settings) -> None:
        super().__init__(role, I2cxlMake(role, settings))
