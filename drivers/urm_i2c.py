"""DFRobot URM09, and URM13 in its I2C mode: registers, a thermometer, and ranges to choose from.

Their distances are true in any air: they measure the temperature and reckon with it.
"""

from dataclasses import dataclass
from typing import Protocol

from echogrid.drivers.bus import I2cTransfer
from echogrid.drivers.course import Course
from echogrid.drivers.device import State
from echogrid.drivers.i2c_chip import require_address
from echogrid.drivers.i2c_ranger import I2cRanger
from echogrid.drivers.limits import require_between
from echogrid.drivers.make import MILLISECOND_NS, Answer, Trouble
from echogrid.drivers.one_message import OneMessageMake
from echogrid.drivers.role import RangerRole

ADDRESS = 0x00
"""The first register: address, product, version, distance in cm (high byte first), and so on."""
MEASURE = 0x01
NOTHING_CM = 0xFFFF
PING_NS = 100 * MILLISECOND_NS
"""The maker's wait. They acknowledge all the time: read too early, they tell the ping before."""
PATIENCE_NS = 40 * MILLISECOND_NS
REST_NS = 98 * MILLISECOND_NS
SETTLING_NS = 100 * MILLISECOND_NS
"""The maker's wait after the configuration, in which a ranging under way ends as well."""
RESOLUTION_NS = 29_000
"""Sound goes a centimetre in that time."""


@dataclass(frozen=True, slots=True)
class Span:
    """One of the ranges that it can be set to."""

    configuration: int
    """The register's value for it: one ping a command, the own thermometer."""
    nearest: float
    """m."""
    farthest: float
    """m."""


@dataclass(frozen=True, slots=True)
class Model:
    """Where one of the two differs from the other."""

    name: str
    product: int
    configuration: int
    """The register of the mode and the range."""
    command: int
    """The register that fires it."""
    spans: tuple[Span, ...]
    """The shortest first."""

    def span(self, farthest: float) -> Span:
        """The shortest range which is that long (m). Raises ValueError if there is none."""
        require_between("max_m", farthest, 0.0, self.spans[-1].farthest)
        return next(span for span in self.spans if farthest <= span.farthest)


URM09 = Model(
    "URM09", 0x01, 0x07, 0x08, (Span(0x00, 0.02, 1.5), Span(0x10, 0.02, 3.0), Span(0x20, 0.02, 5.0))
)
URM13 = Model("URM13", 0x02, 0x09, 0x0A, (Span(0x14, 0.15, 1.5), Span(0x04, 0.4, 9.0)))


def address_change(address: int) -> bytes:
    """The message that gives one another address (7 bit), for good, from the next power-up on.

    Raises ValueError for an address that it can't have.
    """
    require_address(address)
    return bytes((ADDRESS, address))


class Settings(Protocol):
    """The keys that both have."""

    @property
    def address(self) -> int:
        """7 bit."""
        ...

    @property
    def no_echo_cm(self) -> tuple[int, ...]:
        """What it says when it hears nothing."""
        ...


class UrmMake(OneMessageMake):
    """The messages of both."""

    ping_ns = PING_NS
    patience_ns = PATIENCE_NS
    rest_ns = REST_NS

    def __init__(self, role: RangerRole, settings: Settings, model: Model) -> None:
        super().__init__(settings.address, bytes((model.command, MEASURE)), RESOLUTION_NS)
        self._model = model
        self._no_echo_cm = settings.no_echo_cm
        self._span = model.span(role.farthest)
        self._identity = b""

    def set_up(self) -> Course[I2cTransfer, Trouble | None]:
        """Look who is there, and choose one ping a command and the range.

        What is set already is not written again: some keep it in a memory that wears out.
        """
        data = yield from self.collect()
        if not data:
            return self._chip.missing()
        if data[1] != self._model.product or not data[2]:
            return self._stranger(data[1], data[2])
        self._identity = data[:3]
        if data[-1] == self._span.configuration:
            return None
        written = yield from self._chip.insisting.write(self._model.configuration, self._span.configuration)
        yield written.end_ns + SETTLING_NS
        data = yield from self.collect()
        if not data:
            return self._chip.missing()
        return None if data[-1] == self._span.configuration else self._stubborn(data[-1])

    def collect(self) -> Course[I2cTransfer, bytes]:
        """All registers up to the configuration; nothing if nobody drives the bus."""
        data = yield from self._chip.insisting.read(ADDRESS, self._model.configuration + 1)
        return b"" if set(data) == {0xFF} else data

    def answer(self, data: bytes) -> Answer:
        """What the registers mean."""
        if data[:3] != self._identity:
            doubt = f"address, product and version {data[:3].hex()} were {self._identity.hex()} at the set-up"
            return Answer(doubt=f"{doubt}: two devices at one address?", state=State.CONFLICT)
        if data[-1] != self._span.configuration:
            return Answer(doubt=f"its configuration {data[-1]:#04x} is not the one set: did it restart?")
        centimetres = int.from_bytes(data[3:5], "big")
        if centimetres in self._no_echo_cm:
            return Answer()
        if not 0 < centimetres <= 110 * self._span.farthest:
            limit = f"1 to {100 * self._span.farthest:.0f}"
            return Answer(doubt=f"{centimetres} cm is no range ({limit})", gone=False)
        return Answer((centimetres / 100,), nearest=self._span.nearest)

    def _stranger(self, product: int, version: int) -> Trouble:
        """Another make; or two devices, whose zeros win on the bus, so that only ones are missing."""
        found = f"{self.where} is product {product:#04x} version {version:#04x}"
        wanted = f"product {self._model.product:#04x}, a {self._model.name}"
        if product & self._model.product == product:
            return Trouble(State.CONFLICT, f"{found} instead of {wanted}: two devices at one address?")
        return Trouble(State.WRONG_DEVICE, f"{found}, not {wanted}: give its own driver, or its address")

    def _stubborn(self, configuration: int) -> Trouble:
        wanted = self._span.configuration
        return Trouble(
            State.FAULTY,
            f"{self.where} keeps its configuration {configuration:#04x} instead of {wanted:#04x}: "
            f"is it a {self._model.name}?",
        )


class Urm09(I2cRanger):
    """One URM09."""

    @dataclass(frozen=True, slots=True)
    class Settings:
        """Its keys in a config file."""

        address: int = 0x11
        """7 bit."""
        no_echo_cm: tuple[int, ...] = (NOTHING_CM,)
        """What it says when it hears nothing."""

        def __post_init__(self) -> None:
            _require_possible(self)

    def __init__(self, role: RangerRole, settings: Settings) -> None:
        super().__init__(role, UrmMake(role, settings, URM09))


class Urm13I2c(I2cRanger):
    """One URM13 in its I2C mode."""

    @dataclass(frozen=True, slots=True)
    class Settings:
        """Its keys in a config file."""

        address: int = 0x12
        """7 bit."""
        no_echo_cm: tuple[int, ...] = (NOTHING_CM,)
        """What it says when it hears nothing; not documented, perhaps 0."""

        def __post_init__(self) -> None:
            _require_possible(self)

    def __init__(self, role: RangerRole, settings: Settings) -> None:
        super().__init__(role, UrmMake(role, settings, URM13))


def _require_possible(settings: Settings) -> None:
    """Raise ValueError, naming the key, for what can't be."""
    require_address(settings.address)
    for code in settings.no_echo_cm:
        require_between("no_echo_cm", code, 0, 0xFFFF)
