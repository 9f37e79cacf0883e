"""Devantech SRF08: a ranger on I2C which pings when it is told to, and tells up to seventeen echoes."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import ceil
from typing import ClassVar

from echogrid.drivers.bus import I2cResult, I2cTransfer, Result
from echogrid.drivers.commanded import MILLISECOND_NS, Answer, CommandedRanger, Fired, Trouble
from echogrid.drivers.course import Course
from echogrid.drivers.device import Line, State
from echogrid.drivers.i2c_chip import GENERAL_CALL, Chip, fired, overheard
from echogrid.drivers.limits import require_between
from echogrid.drivers.role import RangerRole

COMMAND, GAIN, RANGE = range(3)
"""The registers that can be written; all are lost at power-off."""
REVISION = 0
"""The first register to read: revision, light, and from there on the echoes' high and low bytes."""
RANGE_MICROSECONDS = 0x52
MOST_ECHOES = 17

GATE_STEP = 0.043
"""m of reach for each step of the range register."""
GATE_SPEED = 343.0
"""m/s: what the data sheet's metres of the range register are counted in."""

REST_NS = 58 * MILLISECOND_NS
"""The maker's 60 ms between pings, less the lateness of a turn: late echoes look like near obstacles."""
OVERHEAD_NS = 1 * MILLISECOND_NS
PATIENCE_NS = 70 * MILLISECOND_NS
"""It pings for 65 ms when it forgot its range."""
RESOLUTION_NS = 1_000
"""The chip counts microseconds."""


def range_register(farthest: float, speed_of_sound: float) -> int:
    """The least value with which the chip listens until an echo from `farthest` (m) is back.

    Raises ValueError if there is none.
    """
    steps = ceil(farthest * GATE_SPEED / speed_of_sound / GATE_STEP)
    require_between("farthest", farthest, 0.0, round(256 * GATE_STEP * speed_of_sound / GATE_SPEED, 2))
    return max(steps, 1) - 1


def gate_us(register: int) -> float:
    """How long the chip listens."""
    return (register + 1) * GATE_STEP * 2e6 / GATE_SPEED


def ready(registers: bytes) -> bool:
    """Whether the chip answered: while it pings nobody drives the bus, and a master reads ones."""
    return len(registers) >= 4 and registers[0] not in (0x00, 0xFF)


def echoes_us(registers: bytes) -> tuple[int, ...]:
    """Times of flight, there and back, nearest first; a zero ends the list."""
    times = [int.from_bytes(registers[at : at + 2], "big") for at in range(2, len(registers) - 1, 2)]
    return tuple(times[: times.index(0)] if 0 in times else times)


class Srf08Make:
    """The SRF08's messages."""

    patience_ns = PATIENCE_NS
    rest_ns = REST_NS

    def __init__(self, role: RangerRole, settings: "Srf08.Settings") -> None:
        self._chip = Chip(settings.address)
        self.where = self._chip.where
        self.idle = self._chip.idle
        self._gain = settings.gain
        self._echoes = settings.echoes
        self._speed_of_sound = role.speed_of_sound
        self._range = range_register(role.farthest, role.speed_of_sound)
        self.ping_ns = round(gate_us(self._range) * 1e3) + OVERHEAD_NS
        self._revision = 0

    def set_up(self) -> Course[I2cTransfer, Trouble | None]:
        """Look whether it is there, and write its gain and range."""
        registers = yield from self._chip.read(REVISION, 4)
        if not ready(registers):
            return self._chip.missing()
        self._revision = registers[0]
        for register, value in ((GAIN, self._gain), (RANGE, self._range)):
            result = yield from self._chip.write(register, value)
            if result.errno:
                return self._chip.missing()
        return None

    def fire(self, listens: bool) -> Course[I2cTransfer, Fired]:
        """Start a ping; this chip can't listen without one."""
        del listens
        return fired((yield from self._chip.write(COMMAND, RANGE_MICROSECONDS)), RESOLUTION_NS)

    def fire_all(self) -> Course[I2cTransfer, Fired]:
        """Start a ping of every SRF08 on the bus."""
        return fired((yield from GENERAL_CALL.write(COMMAND, RANGE_MICROSECONDS)), RESOLUTION_NS)

    def called(self, result: Result[I2cTransfer]) -> Fired | None:
        """The ping that another one started."""
        return overheard(result, bytes((COMMAND, RANGE_MICROSECONDS)), RESOLUTION_NS)

    def collect(self) -> Course[I2cTransfer, bytes]:
        """Revision, light and echoes; nothing while it pings."""
        registers = yield from self._chip.read(REVISION, 2 + 2 * self._echoes)
        return registers if ready(registers) else b""

    def answer(self, data: bytes) -> Answer:
        """What the registers mean."""
        if data[0] != self._revision:
            doubt = f"revision {data[0]} was {self._revision} at the set-up"
            return Answer(doubt=f"{doubt}: two devices at one address?", state=State.CONFLICT)
        times = echoes_us(data)
        if times and times[-1] > 1.1 * gate_us(self._range) + 500:
            return Answer(doubt=f"{times[-1]} us is longer than it listened")
        return Answer(tuple(time * 1e-6 * self._speed_of_sound / 2 for time in times))


class Srf08(CommandedRanger[I2cTransfer]):
    """One SRF08."""

    bus: ClassVar[str] = "i2c"
    line: ClassVar[type[Line[I2cResult, I2cTransfer]]] = Line
    identity: ClassVar[str] = "address"
    port_options: ClassVar[Mapping[str, object]] = {}

    @dataclass(frozen=True, slots=True)
    class Settings:
        """Its keys in a config file."""

        address: int = 0x70
        """7 bit."""
        gain: int = 31
        """The step at which its rising amplification stops."""
        echoes: int = 1
        """How many are read of each ping: the second and later ones cost 0.2 ms each on the bus."""

        def __post_init__(self) -> None:
            require_between("address", self.address, 0x70, 0x7F)
            require_between("gain", self.gain, 0, 31)
            require_between("echoes", self.echoes, 1, MOST_ECHOES)

    def __init__(self, role: RangerRole, settings: Settings) -> None:
        super().__init__(role, Srf08Make(role, settings))
