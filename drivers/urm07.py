"""DFRobot URM07, URM06 and URM04 on a UART: several on one line, in frames with an address and a sum."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from echogrid.drivers.bus import Result, SerialTransfer
from echogrid.drivers.commanded import CommandedRanger
from echogrid.drivers.conversation import Conversation
from echogrid.drivers.course import Course
from echogrid.drivers.device import State
from echogrid.drivers.limits import require_between
from echogrid.drivers.make import MILLISECOND_NS, Answer, Fired, Make, Trouble
from echogrid.drivers.role import RangerRole
from echogrid.drivers.serial_talk import (
    SILENCE,
    answered,
    ask,
    ending_in,
    exactly,
    fired,
    tell,
    unanswered,
)

HEAD = b"\x55\xaa"
TRIGGER, DISTANCE, TEMPERATURE = 0x01, 0x02, 0x03
"""Commands. The trigger is not answered, and only the URM04's."""
MOVE = 0x55
"""The command with a new address; the reply to it has one byte of data."""
REPLY_LENGTH = 8
"""Head, address, length, command, two bytes of data with the high byte first, sum."""
FIRST_ADDRESS, LAST_ADDRESS = 0x11, 0x80
NOTHING = 0xFFFF

PING_NS = 60 * MILLISECOND_NS
"""The URM07's measuring period."""
TRIGGERED_NS = 30 * MILLISECOND_NS
"""After which the URM04 has its distance, says its maker; it can't be before the sound is back."""
MARGIN_NS = 5 * MILLISECOND_NS
REPLY_WITHIN_NS = 100 * MILLISECOND_NS
ERROR_NS = 3 * MILLISECOND_NS
"""It takes its temperature before it pings."""
FARTHEST = 10.0
"""m: the URM06's; the URM07 hears 7.5, the URM04 5."""
SLACK = 1.1
"""So many times that it may tell a distance."""


def frame(address: int, command: int, data: bytes = b"") -> bytes:
    """A request or a reply."""
    body = HEAD + bytes((address, len(data), command)) + data
    return body + bytes((sum(body) & 0xFF,))


def word_of(address: int, command: int, data: bytes) -> int | None:
    """What the reply to a command says; None if this does not end in one."""
    tail = data[-REPLY_LENGTH:]
    is_reply = tail == frame(address, command, tail[5:7]) and len(tail) == REPLY_LENGTH
    return int.from_bytes(tail[5:7], "big") if is_reply else None


def address_change(old: int, new: int) -> tuple[SerialTransfer]:
    """The message that gives the ranger which hears it another address. Raises ValueError if it can't be.

    The reply comes from the new one.
    """
    require_between("address", new, FIRST_ADDRESS, LAST_ADDRESS)
    message = frame(old, MOVE, bytes((new,)))
    return (SerialTransfer((message,), exactly(REPLY_LENGTH - 1), REPLY_WITHIN_NS),)


class Urm07Make(Make[SerialTransfer]):
    """Their messages."""

    idle = SILENCE
    patience_ns = 0
    rest_ns = PING_NS

    def __init__(self, role: RangerRole, settings: "Urm07.Settings") -> None:
        self.where = f"address {settings.address:#04x}"
        require_between("max_m", role.farthest, 0.0, FARTHEST)
        self._address = settings.address
        self._baud = settings.baud
        self._unit = settings.unit_mm / 1000
        self._no_echo = settings.no_echo
        self._triggers = settings.triggers
        flight_ns = round(2e9 * role.farthest / role.speed_of_sound)
        self.ping_ns = max(TRIGGERED_NS, flight_ns + MARGIN_NS) if settings.triggers else PING_NS

    def set_up(self) -> Course[SerialTransfer, Trouble | None]:
        """Look whether it is there, by its temperature: it need not ping for that."""
        result = yield from self._ask(TEMPERATURE)
        return unanswered(self.where, result, self._baud) if result.errno else None

    def fire(self, listens: bool) -> Course[SerialTransfer, Fired]:
        """Ask for the distance, for which it pings, or trigger it; it can't listen without."""
        del listens
        if self._triggers:
            return fired((yield from tell(frame(self._address, TRIGGER))), ERROR_NS)
        return answered((yield from self._ask(DISTANCE)), ERROR_NS)

    def collect(self) -> Course[SerialTransfer, bytes]:
        """The reply with the distance, of one that was triggered."""
        return (yield from self._ask(DISTANCE)).data

    def answer(self, data: bytes) -> Answer:
        """What the reply means."""
        word = word_of(self._address, DISTANCE, data)
        if word is None:
            doubt = f"no reply but {data.hex(' ')}: noise, or two devices at one address"
            return Answer(doubt=doubt, state=State.GARBLED)
        if word in self._no_echo:
            return Answer()
        distance = word * self._unit
        if distance > SLACK * FARTHEST:
            doubt = f"{word} would be {distance:.2f} m, beyond its range: is its unit another?"
            return Answer(doubt=doubt, gone=False)
        return Answer((distance,))

    def _ask(self, command: int) -> Course[SerialTransfer, Result[SerialTransfer]]:
        reply = ending_in(lambda tail: word_of(self._address, command, tail) is not None, REPLY_LENGTH)
        return (yield from ask(frame(self._address, command), reply, REPLY_WITHIN_NS))


class Urm07(CommandedRanger[SerialTransfer]):
    """One of them."""

    bus: ClassVar[str] = "serial"
    line: ClassVar[type[Conversation]] = Conversation
    identity: ClassVar[str] = "address"

    @dataclass(frozen=True, slots=True)
    class Settings:
        """Its keys in a config file."""

        address: int = 0x11
        """As it is delivered."""
        baud: int = 19_200
        """The URM04's is 115 200."""
        unit_mm: float = 10.0
        """Of the distance: the URM07 and the URM04 count centimetres, the URM06 millimetres."""
        triggers: bool = False
        """It pings at one command and tells the distance at another, as the URM04; else one does both."""
        no_echo: tuple[int, ...] = (NOTHING,)
        """What the distance says when nothing is heard."""

        def __post_init__(self) -> None:
            require_between("address", self.address, FIRST_ADDRESS, LAST_ADDRESS)
            require_between("baud", self.baud, 1200, 921_600)
            require_between("unit_mm", self.unit_mm, 0.1, 100.0)
            for code in self.no_echo:
                require_between("no_echo", code, 0, 0xFFFF)

    def __init__(self, role: RangerRole, settings: Settings) -> None:
        super().__init__(role, Urm07Make(role, settings))
        self.port_options: Mapping[str, object] = {"baud": settings.baud}
