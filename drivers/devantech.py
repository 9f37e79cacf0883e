"""What Devantech's rangers on I2C share: their registers, who is who, how long a ping takes, the address."""

from abc import abstractmethod
from typing import ClassVar

from echogrid.drivers import i2c_chip
from echogrid.drivers.bus import I2cTransfer
from echogrid.drivers.course import Course
from echogrid.drivers.device import State
from echogrid.drivers.i2c_chip import Chip, fired
from echogrid.drivers.make import MILLISECOND_NS, Answer, Fired, Make, Trouble
from echogrid.drivers.role import RangerRole

COMMAND, GAIN, RANGE = range(3)
"""The registers that can be written. Gain and range, of those which have them, are lost at power-off."""
REVISION = 0
"""The first register to read: revision, light or nothing, and the first echo's high and low byte."""
MICROSECONDS = 0x52
"""The command for a ping whose answer is the time of flight, there and back."""
FIRST_ADDRESS, LAST_ADDRESS = 0x70, 0x7F
UNUSED = 0x80
"""What register 1 reads where nothing is behind it."""

GATE_SPEED = 343.0
"""m/s: what the data sheet's metres of the range register are counted in."""

FULL_PING_NS = 65 * MILLISECOND_NS
"""A ping with no range set; the SRF02 knows no other."""
OVERHEAD_NS = 1 * MILLISECOND_NS
PATIENCE_NS = 70 * MILLISECOND_NS
"""One which forgot its range pings for 65 ms."""
LATE_NS = 12 * MILLISECOND_NS
"""No clock of theirs is so far off: what is busy for longer is not set up, or another one."""
REST_NS = 58 * MILLISECOND_NS
"""The maker's 60 ms between pings, less the lateness of a turn: late echoes look like near obstacles."""
RESOLUTION_NS = 1_000
"""The chips count microseconds."""


def require_address(address: int) -> None:
    """Raise ValueError for an address (7 bit) that they can't have."""
    i2c_chip.require_address(address, FIRST_ADDRESS, LAST_ADDRESS)


def address_change(address: int) -> tuple[bytes, ...]:
    """The messages that give a chip another address (7 bit), for good: each a transfer of its own.

    No other message may go to the chip in between, and no second one may hear them. Raises ValueError for an
    address that it can't have.
    """
    require_address(address)
    return tuple(bytes((COMMAND, value)) for value in (0xA0, 0xAA, 0xA5, address << 1))


def ready(registers: bytes, count: int) -> bool:
    """Whether the chip gave so many: while it pings nobody drives the bus, and a master reads ones."""
    return len(registers) == count > 0 and registers[0] not in (0x00, 0xFF)


def words(registers: bytes) -> tuple[int, ...]:
    """Pairs of registers, high byte first."""
    return tuple(int.from_bytes(registers[at : at + 2], "big") for at in range(0, len(registers) - 1, 2))


def pulled_down(registers: bytes, before: bytes) -> bool:
    """Whether bits are missing that were there before, and none came: so do two who drive the bus at once."""
    left = bytes(now & was for now, was in zip(registers, before, strict=False))
    return registers != before and registers == left


class DevantechMake(Make[I2cTransfer]):
    """The half of a make that is alike in all of them."""

    name: ClassVar[str]
    fixed: ClassVar[int] = 2
    """So many of the first registers never change."""
    kin: ClassVar[str] = ""
    """Those which ping for 65 ms and would be taken for it, if that were not noticed."""
    patience_ns = PATIENCE_NS
    rest_ns = REST_NS
    ping_ns: int

    def __init__(self, role: RangerRole, address: int, registers: int) -> None:
        """`registers` are read of each ping."""
        self._chip = Chip(address)
        self.where = self._chip.where
        self.idle = self._chip.idle
        self._count = registers
        self._speed_of_sound = role.speed_of_sound
        self._settings: tuple[tuple[int, int], ...] = ()
        self._identity = b""
        self._timely = False
        self._fired_ns = self._busy_ns = self._took_ns = 0

    def set_up(self) -> Course[I2cTransfer, Trouble | None]:
        """Look who is there, and whether it says the same twice; then write the settings."""
        first = yield from self._chip.insisting.read(REVISION, 2)
        second = first and (yield from self._chip.insisting.read(REVISION, 2))
        if trouble := self._trouble(first, second):
            return trouble
        if not (yield from self._set()):
            return self._chip.missing()
        self._identity = first[: self.fixed]
        self._timely = False
        return None

    def fire(self, listens: bool) -> Course[I2cTransfer, Fired]:
        """Start a ping, or what is the same without the sound where that is possible."""
        result = yield from self._chip.insisting.write(COMMAND, self._command(listens))
        return self._begun(fired(result, RESOLUTION_NS))

    def collect(self) -> Course[I2cTransfer, bytes]:
        """The registers; nothing while it pings."""
        pointed = yield from self._chip.send(bytes((REVISION,)))
        registers = b"" if pointed.errno else (yield from self._chip.take(self._count))
        passed_ns = pointed.start_ns - self._fired_ns
        if not ready(registers, self._count):
            self._busy_ns = passed_ns
            return b""
        self._took_ns = passed_ns
        return registers

    def answer(self, data: bytes) -> Answer:
        """What the registers mean."""
        return self._mixed_up(data) or self._late(data) or self._heard(data)

    def _set(self) -> Course[I2cTransfer, bool]:
        """Write the settings; whether it took them."""
        for register, value in self._settings:
            result = yield from self._chip.insisting.write(register, value)
            if result.errno:
                return False
        return True

    def _begun(self, ping: Fired) -> Fired:
        """Note when a ping began."""
        self._fired_ns = ping.stamp_ns
        self._busy_ns = 0
        return ping

    def _metres(self, microseconds: float) -> float:
        """How far away something is, by the time of the sound there and back."""
        return microseconds * 1e-6 * self._speed_of_sound / 2

    def _trouble(self, first: bytes, second: bytes) -> Trouble | None:
        """Why those who answer are not this one alone, by their first registers, read twice."""
        if not (ready(first, 2) and ready(second, 2)):
            self._identity = b""
            return self._chip.missing()
        if first != second:
            said = f"{self.where} reads {first.hex(' ')}, then {second.hex(' ')}"
            return Trouble(State.GARBLED, f"{said}: is the bus too fast, too long, without pull-ups?")
        if self._identity and pulled_down(first[: self.fixed], self._identity):
            said = f"{self.where}: {self._changed(first)}"
            return Trouble(State.CONFLICT, f"{said}: give two devices two addresses (echogrid scan)")
        if not self._fits(first[1]):
            said = f"{self.where}: register 1 reads {first[1]:#04x}, as no {self.name}'s does"
            return Trouble(State.WRONG_DEVICE, f"{said}: is it another device, or are there two?")
        return None

    def _changed(self, registers: bytes) -> str:
        was, now = self._identity, registers[: self.fixed]
        return f"it reads {now.hex(' ')} where it read {was.hex(' ')}"

    def _mixed_up(self, data: bytes) -> Answer | None:
        """The doubt whether this one, and no other with it, has answered."""
        if data[: self.fixed] == self._identity:
            return None
        said = self._changed(data)
        if pulled_down(data[: self.fixed], self._identity):
            return Answer(doubt=f"{said}: two devices at one address?", state=State.CONFLICT)
        return Answer(doubt=f"{said}: noise on the bus, or another device?", state=State.GARBLED)

    def _late(self, data: bytes) -> Answer | None:
        """The doubt whether it is set up, or the right one, since it was busy for so long."""
        if self._busy_ns <= self.ping_ns + LATE_NS:
            self._timely = True
            return None
        expected_ms, busy_ms = self.ping_ns // MILLISECOND_NS, self._busy_ns // MILLISECOND_NS
        said = f"busy for {busy_ms} ms, not {expected_ms}"
        if self._timely and self._settings:
            return Answer(doubt=f"{said}: it lost its settings (was its power cut?)")
        is_full = self._busy_ns - LATE_NS / 2 < FULL_PING_NS < self._took_ns + LATE_NS / 2
        if not self._timely and is_full and self._may_be_kin(data[1]):
            return Answer(doubt=f"{said}: is it an {self.kin}?", state=State.WRONG_DEVICE)
        return Answer(doubt=f"{said}: is it failing?")

    def _fits(self, register: int) -> bool:
        """Whether register 1 may read so."""
        return register == UNUSED

    def _may_be_kin(self, register: int) -> bool:
        """Whether one of its kin may read so in register 1."""
        del register
        return bool(self.kin)

    @abstractmethod
    def _command(self, listens: bool) -> int:
        """What starts a ping."""

    @abstractmethod
    def _heard(self, data: bytes) -> Answer:
        """What the registers say of the ping, when nothing speaks against them."""
