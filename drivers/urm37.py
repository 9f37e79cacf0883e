"""DFRobot URM37: a ranger on a serial line of its own, whose reply to the command is the distance."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import ClassVar

from echogrid.drivers.bus import SerialTransfer
from echogrid.drivers.commanded import CommandedRanger
from echogrid.drivers.conversation import Conversation
from echogrid.drivers.course import Course
from echogrid.drivers.device import State
from echogrid.drivers.limits import require_between
from echogrid.drivers.make import MILLISECOND_NS, Answer, Fired, Make, Trouble
from echogrid.drivers.role import RangerRole
from echogrid.drivers.serial_talk import SILENCE, answered, ask, ending_in, unanswered

BAUD = 9600
TEMPERATURE, DISTANCE = 0x11, 0x22
"""Commands, and the first byte of the replies to them."""
LENGTH = 4
"""Bytes of a request and of a reply: command, two of data with the high byte first, sum."""
NOTHING = 0xFFFF
NO_TEMPERATURE = 0x55AA
"""The data of a request are free: these can't come back but as an echo."""

PING_NS = 75 * MILLISECOND_NS
"""The maker's wait."""
REPLY_WITHIN_NS = 300 * MILLISECOND_NS
"""It is alone on its line: patience costs nobody anything."""
ERROR_NS = 5 * MILLISECOND_NS
"""How long after the request it pings is not documented."""
FARTHEST = 8.0
"""m."""
SLACK = 1.25
"""So many times that it may tell a distance."""


def frame(command: int, word: int = 0) -> bytes:
    """A request or a reply."""
    body = bytes((command,)) + word.to_bytes(2, "big")
    return body + bytes((sum(body) & 0xFF,))


def word_of(command: int, data: bytes) -> int | None:
    """What the reply to a command says; None if this does not end in one."""
    tail = data[-LENGTH:]
    word = int.from_bytes(tail[1:3], "big")
    return word if tail == frame(command, word) else None


class Urm37Make(Make[SerialTransfer]):
    """The URM37's messages."""

    where = "the URM37"
    idle = SILENCE
    ping_ns = PING_NS
    rest_ns = PING_NS
    patience_ns = 0

    def __init__(self, role: RangerRole, settings: "Urm37.Settings") -> None:
        require_between("max_m", role.farthest, 0.0, FARTHEST)
        self._unit = settings.unit_mm / 1000
        self._no_echo = settings.no_echo

    def set_up(self) -> Course[SerialTransfer, Trouble | None]:
        """Look whether it is there, by its temperature: it need not ping for that."""
        request = frame(TEMPERATURE, NO_TEMPERATURE)
        result = yield from ask(request, _reply_to(TEMPERATURE), REPLY_WITHIN_NS)
        if result.errno:
            return unanswered(self.where, result, BAUD)
        if result.data == request:
            return Trouble(State.GARBLED, f"what is sent to {self.where} is heard back: join no RX to TX")
        return None

    def fire(self, listens: bool) -> Course[SerialTransfer, Fired]:
        """Ask for the distance, for which it pings; it can't listen without."""
        del listens
        result = yield from ask(frame(DISTANCE), _reply_to(DISTANCE), REPLY_WITHIN_NS)
        return answered(result, ERROR_NS)

    def collect(self) -> Course[SerialTransfer, bytes]:
        """Nothing: the answer came with the ping."""
        yield from ()
        return b""

    def answer(self, data: bytes) -> Answer:
        """What the reply means."""
        word = word_of(DISTANCE, data)
        if word is None:
            doubt = f"no reply but {data.hex(' ')}: noise, or is its jumper set to RS232?"
            return Answer(doubt=doubt, state=State.GARBLED)
        if word in self._no_echo:
            return Answer()
        distance = word * self._unit
        if distance > SLACK * FARTHEST:
            doubt = f"{word} would be {distance:.2f} m, beyond its range: is its unit another?"
            return Answer(doubt=doubt, gone=False)
        return Answer((distance,))


def _reply_to(command: int) -> Callable[[bytes], int]:
    return ending_in(lambda tail: word_of(command, tail) is not None, LENGTH)


class Urm37(CommandedRanger[SerialTransfer]):
    """One URM37, alone on its line."""

    bus: ClassVar[str] = "serial"
    line: ClassVar[type[Conversation]] = Conversation
    identity: ClassVar[str] = ""
    port_options: ClassVar[Mapping[str, object]] = {"baud": BAUD}

    @dataclass(frozen=True, slots=True)
    class Settings:
        """Its keys in a config file."""

        unit_mm: float = 10.0
        """Of the distance."""
        no_echo: tuple[int, ...] = (NOTHING,)
        """What the distance says when nothing is heard."""

        def __post_init__(self) -> None:
            require_between("unit_mm", self.unit_mm, 0.1, 100.0)
            for code in self.no_echo:
                require_between("no_echo", code, 0, 0xFFFF)

    def __init__(self, role: RangerRole, settings: Settings) -> None:
        super().__init__(role, Urm37Make(role, settings))
