"""DFRobot URM12, URM13, URM14 and URM15: rangers on RS485 (URM13: a UART) which speak Modbus RTU."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from echogrid.drivers.bus import SerialTransfer
from echogrid.drivers.commanded import CommandedRanger
from echogrid.drivers.conversation import Conversation
from echogrid.drivers.course import Course
from echogrid.drivers.device import State
from echogrid.drivers.limits import require_between
from echogrid.drivers.make import MILLISECOND_NS, Answer, Fired, Trouble
from echogrid.drivers.modbus import BUSY, read, write
from echogrid.drivers.modbus_line import ModbusMake, ModbusSettings
from echogrid.drivers.role import RangerRole
from echogrid.drivers.serial_talk import exactly

PRODUCT, ADDRESS, DISTANCE, CONTROL = 0x00, 0x02, 0x05, 0x08
"""Registers. Behind the product stands its version, between distance and control two temperatures."""
PASSIVE, TRIGGER, SHORT = 0x04, 0x08, 0x10
"""Bits of the control register: ping on command only; do so once; the short range (URM13)."""
SETTLED = 0x07 | SHORT
"""The bits that are set up. Bits 0 and 1 clear: the distance is corrected by the device's own thermometer."""
SLACK = 1.1
"""So many times its range it may tell a distance."""
CHANGE_WITHIN_NS = 500 * MILLISECOND_NS
"""The maker's wait for a reply; it need not be quick."""
PATIENCE_NS = 100 * MILLISECOND_NS

PRODUCTS: Mapping[int, str] = {1: "URM12", 2: "URM14", 3: "URM13", 5: "URM15"}


@dataclass(frozen=True, slots=True)
class Range:
    """From where to where it hears (m)."""

    nearest: float
    farthest: float


@dataclass(frozen=True, slots=True)
class Kind:
    """What tells one model from another."""

    product: int
    unit: float
    """m, of the distance register."""
    range: Range
    control: int = PASSIVE
    """What its control register is to be."""


@dataclass(frozen=True, slots=True)
class UrmSettings(ModbusSettings):
    """The keys in a config file that all four have."""

    baud: int = 19_200
    ping_ms: float = 100.0
    """From the command to the distance."""
    reply_ms: float = 100.0
    """For how long a reply is waited for."""
    clears_trigger: bool = False
    """It clears the trigger bit itself, by the end of the ping: then a slow ping is waited for."""
    no_echo: tuple[int, ...] = (0xFFFF,)
    """What the distance register says when nothing is heard."""

    def __post_init__(self) -> None:
        ModbusSettings.__post_init__(self)
        require_between("ping_ms", self.ping_ms, 5.0, 2000.0)
        require_between("reply_ms", self.reply_ms, 10.0, 2000.0)
        for code in self.no_echo:
            require_between("no_echo", code, 0, 0xFFFF)


class UrmMake(ModbusMake):
    """Their requests."""

    patience_ns = PATIENCE_NS

    def __init__(self, role: RangerRole, settings: UrmSettings, kind: Kind) -> None:
        require_between("max_m", role.farthest, 0.0, kind.range.farthest)
        super().__init__(settings)
        self.ping_ns = self.rest_ns = round(settings.ping_ms * 1e6)
        self._within_ns = round(settings.reply_ms * 1e6)
        self._clears_trigger = settings.clears_trigger
        self._no_echo = settings.no_echo
        self._kind = kind
        self._identify = read(settings.address, PRODUCT, 2)
        self._look = read(settings.address, DISTANCE, 4)
        self._settle = write(settings.address, CONTROL, kind.control)
        self._trigger = write(settings.address, CONTROL, kind.control | TRIGGER)

    def set_up(self) -> Course[SerialTransfer, Trouble | None]:
        """Look whether it is what it should be, and have it wait for commands."""
        told = yield from self._unit.ask(self._identify, self._within_ns)
        if told.trouble:
            return told.trouble
        if told.reply.registers[0] != self._kind.product:
            return self._stranger(told.reply.registers[0])
        told = yield from self._unit.ask(self._look, self._within_ns)
        if self._pings(told.reply.registers):
            return Trouble(State.FAULTY, f"{self.where} does not end its ping: is `clears_trigger` right?")
        if not told.trouble and not self._settled(told.reply.registers):
            told = yield from self._unit.ask(self._settle, self._within_ns)
        return told.trouble

    def fire(self, listens: bool) -> Course[SerialTransfer, Fired]:
        """Start a ping, between the end of the command and its repetition; it can't listen without one.

        If the repetition is garbled it has pinged all the same.
        """
        del listens
        told = yield from self._unit.ask(self._trigger, self._within_ns)
        if told.trouble and told.trouble.state is not State.GARBLED:
            return Fired(told.end_ns, 0, told.why, state=told.trouble.state)
        return Fired((told.sent_ns + told.end_ns) // 2, (told.end_ns - told.sent_ns + 1) // 2)

    def collect(self) -> Course[SerialTransfer, bytes]:
        """The reply to a look at its registers; nothing while it is busy or silent."""
        told = yield from self._unit.ask(self._look, self._within_ns)
        busy = told.reply.exception == BUSY or self._pings(told.reply.registers)
        return b"" if busy else told.raw

    def answer(self, data: bytes) -> Answer:
        """What the reply means."""
        reply = self._look.reply(data)
        if trouble := self._unit.trouble(reply):
            return Answer(doubt=reply.doubt or reply.refusal, state=trouble.state)
        if not self._settled(reply.registers):
            doubt = f"control register {reply.registers[3]:#06x} is not what was set up: was it restarted?"
            return Answer(doubt=doubt, state=State.WRONG_DEVICE)
        if reply.registers[0] in self._no_echo:
            return Answer()
        distance = reply.registers[0] * self._kind.unit
        if distance > SLACK * self._kind.range.farthest:
            doubt = f"{reply.registers[0]} would be {distance:.2f} m, beyond its range: is its unit another?"
            return Answer(doubt=doubt, gone=False)
        return Answer((distance,), self._kind.range.nearest)

    def _pings(self, registers: tuple[int, ...]) -> bool:
        return self._clears_trigger and bool(registers) and bool(registers[3] & TRIGGER)

    def _settled(self, registers: tuple[int, ...]) -> bool:
        return registers[3] & SETTLED == self._kind.control

    def _stranger(self, product: int) -> Trouble:
        found = PRODUCTS.get(product, f"product {product:#06x}")
        wanted = PRODUCTS[self._kind.product]
        return Trouble(
            State.WRONG_DEVICE, f"{self.where} is {found}, not {wanted}: check its address and `driver`"
        )


def address_change(old: int, new: int) -> SerialTransfer:
    """The message that gives a URM another address, from its next power-up on: its reply repeats it.

    Raises ValueError if there is no such address.
    """
    require_between("address", old, 1, 247)
    require_between("address", new, 1, 247)
    request = write(old, ADDRESS, new)
    return SerialTransfer((request.frame,), exactly(request.length), CHANGE_WITHIN_NS)


class _Urm(CommandedRanger[SerialTransfer]):
    """What the four have alike."""

    bus: ClassVar[str] = "serial"
    line: ClassVar[type[Conversation]] = Conversation
    identity: ClassVar[str] = "address"

    def __init__(self, role: RangerRole, settings: UrmSettings, kind: Kind) -> None:
        super().__init__(role, UrmMake(role, settings, kind))
        self.port_options: Mapping[str, object] = settings.port_options


class Urm12(_Urm):
    """One URM12: narrow, 15 m, 3 pings a second."""

    @dataclass(frozen=True, slots=True)
    class Settings(UrmSettings):
        """Its keys in a config file."""

        address: int = 0x0B
        ping_ms: float = 350.0
        no_echo: tuple[int, ...] = (0x0000,)

    def __init__(self, role: RangerRole, settings: Settings) -> None:
        super().__init__(role, settings, Kind(1, 0.01, Range(0.7, 15.0)))


class Urm13(_Urm):
    """One URM13 in its UART mode: 0.4 to 9 m, or 0.15 to 1.5 m if no more is asked for."""

    @dataclass(frozen=True, slots=True)
    class Settings(UrmSettings):
        """Its keys in a config file."""

        address: int = 0x0D
        clears_trigger: bool = True
        unit_mm: float = 10.0
        """Of the distance register: the maker's library says 10, his wiki 1."""

        def __post_init__(self) -> None:
            UrmSettings.__post_init__(self)
            require_between("unit_mm", self.unit_mm, 0.1, 100.0)

    def __init__(self, role: RangerRole, settings: Settings) -> None:
        unit = settings.unit_mm / 1000
        short, long = Kind(3, unit, Range(0.15, 1.5), PASSIVE | SHORT), Kind(3, unit, Range(0.4, 9.0))
        super().__init__(role, settings, short if role.farthest <= short.range.farthest else long)


class Urm14(_Urm):
    """One URM14: 200 kHz, narrow, 1.5 m, in tenths of a millimetre."""

    @dataclass(frozen=True, slots=True)
    class Settings(UrmSettings):
        """Its keys in a config file."""

        address: int = 0x0C

    def __init__(self, role: RangerRole, settings: Settings) -> None:
        super().__init__(role, settings, Kind(2, 0.0001, Range(0.1, 1.5)))


class Urm15(_Urm):
    """One URM15: 75 kHz, 5 m."""

    @dataclass(frozen=True, slots=True)
    class Settings(UrmSettings):
        """Its keys in a config file."""

        address: int = 0x0F

    def __init__(self, role: RangerRole, settings: Settings) -> None:
        super().__init__(role, settings, Kind(5, 0.001, Range(0.3, 5.0)))
