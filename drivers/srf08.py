"""Devantech SRF08: a ranger on I2C which pings when it is told to."""

from collections import Counter
from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass
from errno import ETIMEDOUT
from math import ceil
from typing import ClassVar, TypeVar

from echogrid.drivers.bus import I2cMessage, I2cResult, I2cTransfer
from echogrid.drivers.device import Health, Level, Step
from echogrid.drivers.limits import require_between
from echogrid.drivers.readings import Outcome, RangeReading, classify
from echogrid.drivers.role import RangerRole, Slot

COMMAND, GAIN, RANGE = range(3)
"""The registers that can be written; all are lost at power-off."""
REVISION = 0
"""The first register to read: revision, light, first echo's high and low byte."""
RANGE_MICROSECONDS = 0x52

GATE_STEP = 0.043
"""m of reach for each step of the range register."""
GATE_SPEED = 343.0
"""m/s: what the data sheet's metres of the range register are counted in."""

MILLISECOND_NS = 1_000_000
REST_NS = 58 * MILLISECOND_NS
"""The maker's 60 ms between pings, less the lateness of a slot: late echoes look like near obstacles."""
OVERHEAD_NS = 1 * MILLISECOND_NS
POLL_NS = 5 * MILLISECOND_NS
PATIENCE_NS = 70 * MILLISECOND_NS
"""How long past its ping time the chip may be busy: it pings for 65 ms when it forgot its range."""
LATEST_NS = 10 * MILLISECOND_NS
"""A slot which is missed by more is left to the neighbours."""
ANSWER_WITHIN_NS = 1_000 * MILLISECOND_NS
FIRST_BACK_OFF_NS = 100 * MILLISECOND_NS
LONGEST_BACK_OFF_NS = 2_000 * MILLISECOND_NS
STALE_NS = 500 * MILLISECOND_NS
RESOLUTION_NS = 1_000
"""The chip counts microseconds."""

T = TypeVar("T")
Course = Generator[I2cTransfer | int, None, T]
"""What to do, step by step: a transfer is sent and its result awaited, an int is a time to wait for."""


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
    return len(registers) == 4 and registers[0] not in (0x00, 0xFF)


def first_echo_us(registers: bytes) -> int:
    """Time of flight, there and back; 0 when nothing was heard."""
    return int.from_bytes(registers[2:4], "big")


@dataclass(frozen=True, slots=True)
class _Ping:
    fired_ns: int
    error_ns: int


class Srf08:
    """One SRF08: set up, wait for the slot, fire, wait for the chip, read; set up anew when it is missing."""

    bus: ClassVar[str] = "i2c"
    identity: ClassVar[str] = "address"
    port_options: ClassVar[Mapping[str, object]] = {}

    @dataclass(frozen=True, slots=True)
    class Settings:
        """Its keys in a config file."""

        address: int = 0x70
        """7 bit."""
        gain: int = 31
        """The step at which its rising amplification stops."""

        def __post_init__(self) -> None:
            require_between("address", self.address, 0x70, 0x7F)
            require_between("gain", self.gain, 0, 31)

    def __init__(self, role: RangerRole, settings: Settings) -> None:
        self.name = role.name
        self._role = role
        self._settings = settings
        self._range = range_register(role.farthest, role.speed_of_sound)
        self._ping_ns = round(gate_us(self._range) * 1e3) + OVERHEAD_NS
        self._slot = role.slot or Slot(self._ping_ns + REST_NS, 0)
        self._counts: Counter[str] = Counter()
        self._now_ns = 0
        self._fired_ns = -REST_NS
        self._ping: _Ping | None = None
        self._present = False
        self._revision = 0
        self._latest: RangeReading | None = None
        self._readings: list[RangeReading] = []
        self._send: list[I2cTransfer] = []
        self._result = I2cResult(I2cTransfer(()), 0, 0)
        self._start(0)

    def step(self, now_ns: int, received: Sequence[I2cResult]) -> Step[I2cTransfer]:
        """Take the results of own transfers and say what comes next."""
        self._now_ns = now_ns
        for result in received:
            if result.transfer == self._wish:
                self._go_on(result)
        if now_ns >= self._deadline_ns:
            self._overdue()
        step = Step(tuple(self._readings), tuple(self._send), self._deadline_ns)
        self._readings.clear()
        self._send.clear()
        return step

    def lost(self, now_ns: int) -> None:
        """The port was lost: the ping under way is void, and the chip may have lost its set-up with it."""
        self._now_ns = now_ns
        if self._ping is not None:
            self._report(self._stamped(self._ping, Outcome.INVALID, self._role.farthest, "port lost"))
        self._present = False
        self._send.clear()
        self._start(now_ns)

    def health(self, now_ns: int) -> Health:
        """How it is."""
        level, message = self._condition(now_ns)
        return Health(level, message, dict(self._counts))

    def _condition(self, now_ns: int) -> tuple[Level, str]:
        address = f"{self._settings.address:#04x}"
        if not self._present:
            missing = f"no answer at {address} (7 bit): check its power, wires and address"
            return (Level.ERROR, missing) if self._counts["missing"] else (Level.STALE, "not set up yet")
        if self._latest is None or now_ns - self._latest.stamp_ns > 3 * self._slot.period_ns + STALE_NS:
            return Level.STALE, f"no reading from {address} for a while: is its bus held up?"
        if self._latest.outcome is Outcome.INVALID:
            return Level.WARN, f"invalid reading: {self._latest.reason}"
        return Level.OK, "ranging"

    def _start(self, now_ns: int) -> None:
        self._course = self._live()
        self._wish: I2cTransfer | int = now_ns
        self._deadline_ns = now_ns

    def _overdue(self) -> None:
        """The time waited for has come; if it was for a result, that stayed away."""
        if isinstance(self._wish, I2cTransfer):
            self._counts["unanswered transfers"] += 1
            self._go_on(I2cResult(self._wish, self._now_ns, self._now_ns, errno=ETIMEDOUT))
        else:
            self._go_on(self._result)

    def _go_on(self, result: I2cResult) -> None:
        self._result = result
        self._wish = next(self._course)
        while isinstance(self._wish, int) and self._wish <= self._now_ns:
            self._wish = next(self._course)
        if isinstance(self._wish, int):
            self._deadline_ns = self._wish
        else:
            self._send.append(self._wish)
            self._deadline_ns = self._now_ns + ANSWER_WITHIN_NS

    def _live(self) -> Course[None]:
        while True:
            yield from self._set_up()
            while self._present:
                yield from self._take_turn()

    def _set_up(self) -> Course[None]:
        """Come back when the chip is there and knows its gain and range."""
        back_off_ns = FIRST_BACK_OFF_NS
        while not (yield from self._configured()):
            self._counts["missing"] += 1
            yield self._now_ns + back_off_ns
            back_off_ns = min(2 * back_off_ns, LONGEST_BACK_OFF_NS)
        self._counts["set-ups"] += 1
        self._present = True

    def _configured(self) -> Course[bool]:
        registers = yield from self._registers()
        if not ready(registers):
            return False
        self._revision = registers[0]
        for register, value in ((GAIN, self._settings.gain), (RANGE, self._range)):
            result = yield from self._write(register, value)
            if result.errno:
                return False
        return True

    def _take_turn(self) -> Course[None]:
        """Wait for the slot, fire, and report what became of it."""
        slot_ns = self._slot.next_ns(max(self._now_ns, self._fired_ns + REST_NS))
        yield slot_ns
        if self._now_ns - slot_ns > LATEST_NS:
            self._counts["missed slots"] += 1
            return
        result = yield from self._write(COMMAND, RANGE_MICROSECONDS)
        self._fired_ns = (result.start_ns + result.end_ns) // 2
        if result.errno:
            self._counts["failed to fire"] += 1
            self._present = False
            return
        self._ping = _Ping(self._fired_ns, (result.end_ns - result.start_ns + 1) // 2 + RESOLUTION_NS)
        registers = yield from self._awaited_registers(result.end_ns + self._ping_ns)
        self._report(self._reading(self._ping, registers))

    def _awaited_registers(self, expected_ns: int) -> Course[bytes]:
        """What the chip says when its ping is over, or nothing if that takes too long."""
        yield expected_ns
        while not ready(registers := (yield from self._registers())):
            self._counts["busy"] += 1
            if self._now_ns + POLL_NS > expected_ns + PATIENCE_NS:
                return b""
            yield self._now_ns + POLL_NS
        return registers

    def _reading(self, ping: _Ping, registers: bytes) -> RangeReading:
        """A result that cannot be means that the chip is gone, or forgot its range: it is set up again."""
        if doubt := self._doubt(registers):
            self._present = False
            return self._stamped(ping, Outcome.INVALID, self._role.farthest, doubt, registers)
        if (echo_us := first_echo_us(registers)) == 0:
            return self._stamped(ping, Outcome.NO_ECHO, self._role.farthest, raw=registers)
        measured = echo_us * 1e-6 * self._role.speed_of_sound / 2
        outcome, _ = classify(measured, self._role.nearest, self._role.farthest)
        return self._stamped(ping, outcome, min(measured, self._role.farthest), raw=registers)

    def _doubt(self, registers: bytes) -> str:
        """Why this cannot be the result; empty if it can."""
        if not registers:
            return "not ready in time"
        if registers[0] != self._revision:
            return f"revision {registers[0]} was {self._revision} at the set-up"
        if (echo_us := first_echo_us(registers)) > 1.1 * gate_us(self._range) + 500:
            return f"{echo_us} us is longer than it listened"
        return ""

    def _stamped(
        self, ping: _Ping, outcome: Outcome, reached: float, reason: str = "", raw: bytes = b""
    ) -> RangeReading:
        """The reading whose sound had gone `reached` metres at the moment that counts."""
        stamp_ns = ping.fired_ns + round(reached / self._role.speed_of_sound * 1e9)
        distance = reached if outcome is Outcome.ECHO else float("nan")
        return RangeReading(stamp_ns, ping.error_ns, self.name, outcome, distance, raw, reason)

    def _report(self, reading: RangeReading) -> None:
        self._counts[reading.outcome.value] += 1
        self._latest = reading
        self._readings.append(reading)
        self._ping = None

    def _registers(self) -> Course[bytes]:
        """Revision, light and first echo; nothing when the chip does not acknowledge.

        Pointer and read go out as two transfers: behind a repeated start some masters read on
        without an acknowledge, and return garbage.
        """
        pointed = yield from self._transfer(I2cMessage(self._settings.address, write=bytes([REVISION])))
        if pointed.errno:
            return b""
        result = yield from self._transfer(I2cMessage(self._settings.address, read=4))
        return b"" if result.errno else result.data

    def _write(self, register: int, value: int) -> Course[I2cResult]:
        return (yield from self._transfer(I2cMessage(self._settings.address, write=bytes([register, value]))))

    def _transfer(self, message: I2cMessage) -> Course[I2cResult]:
        yield I2cTransfer((message,))
        return self._result
