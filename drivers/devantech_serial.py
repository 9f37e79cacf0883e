"""What Devantech's rangers on serial lines share: address and command, answered without frame or sum."""

from collections.abc import Callable, Mapping
from errno import EPROTO

from echogrid.drivers.bus import Break, Result, SerialTransfer
from echogrid.drivers.course import Course
from echogrid.drivers.device import State
from echogrid.drivers.limits import require_between
from echogrid.drivers.make import MILLISECOND_NS, Answer, Fired, Make, Trouble
from echogrid.drivers.role import RangerRole
from echogrid.drivers.serial_talk import SILENCE, ask_surely, exactly, fired, tell, unanswered

BAUD = 9600
CENTIMETRES, MICROSECONDS = 0x51, 0x52
"""Commands for a ping, by the unit of its answer."""
LISTEN_CENTIMETRES = 0x57
"""The "fake" ranging: all of it but the ping."""
RANGE = 0x5E
"""The command for the answer: two bytes, high byte first."""
UNLOCK = 0xA0, 0xAA, 0xA5
"""Commands behind which the next one is taken for an address."""

PING_NS = 70 * MILLISECOND_NS
"""The maker's wait, after which the answer is always ready."""
REST_NS = 68 * MILLISECOND_NS
"""The same, less the lateness of a turn."""
REPLY_WITHIN_NS = 5 * MILLISECOND_NS
"""Two bytes take 2.3 ms."""
ERROR_NS = 2 * MILLISECOND_NS
"""A byte's time, and that of a USB adapter's frame."""
BREAK = Break(0.003)
"""1.5 ms would do; but USB adapters time it by frames of 1 ms."""
LISTENS_NS = 65 * MILLISECOND_NS
"""And no longer."""
NEAR = 0.1
"""m: a range that differs from the one before by less needs no confirmation."""


def address_change(old: int, new: int, head: tuple[Break, ...] = ()) -> tuple[SerialTransfer, ...]:
    """The messages that give a ranger another address, for good, with nothing else in between."""
    messages = (bytes((old, key)) for key in (*UNLOCK, new))
    return tuple(SerialTransfer((*head, message), echoed=bool(head)) for message in messages)


def never(data: bytes) -> bool:
    """Believe nothing at first."""
    del data
    return False


class DevantechLineMake(Make[SerialTransfer]):
    """The half of a make that is alike in them."""

    idle = SILENCE
    ping_ns = PING_NS
    rest_ns = REST_NS
    patience_ns = 0

    def __init__(
        self, role: RangerRole, address: int, metres: Mapping[int, float], one_wire: bool = False
    ) -> None:
        """`metres` is the unit of the answer to each command, of which the first is for a ping.

        On one wire a break comes before each message, and the message is heard back.
        """
        self.where = f"address {address}"
        require_between("max_m", role.farthest, 0.0, round(LISTENS_NS * 1e-9 * role.speed_of_sound / 2, 2))
        self._longest = LISTENS_NS * 1e-9 * role.speed_of_sound / 2
        self._address = address
        self._metres = metres
        self._head = (BREAK,) if one_wire else ()
        self._command = self._ping = next(iter(metres))
        self._pinged_m: float | None = None
        """What the ping before gave, if it gave something."""

    def set_up(self) -> Course[SerialTransfer, Trouble | None]:
        """Look whether it is there: whether it says the same twice."""
        result = yield from self._read(RANGE, 2, never)
        self._pinged_m = None
        if result.errno:
            return unanswered(self.where, result, BAUD)
        if result.data in result.transfer.send:
            return Trouble(State.GARBLED, f"what is sent to {self.where} is heard back: join no RX to TX")
        return None

    def fire(self, listens: bool) -> Course[SerialTransfer, Fired]:
        """Start a ping, or what is the same without the sound."""
        self._command = LISTEN_CENTIMETRES if listens else self._ping
        result = yield from tell(*self._message(self._command), echoed=bool(self._head))
        return fired(result, ERROR_NS)

    def collect(self) -> Course[SerialTransfer, bytes]:
        """The answer; after noise it is asked for once more. Nothing if there is no reply."""
        result = yield from self._read(RANGE, 2, self._is_near)
        if result.errno == EPROTO:
            result = yield from self._read(RANGE, 2, self._is_near)
        if not result.errno and self._command == self._ping:
            self._pinged_m = self._distance(result.data)
        return result.data

    def answer(self, data: bytes) -> Answer:
        """What the answer means; zero is nothing."""
        if len(data) != 2:
            doubt = f"a reply of the wrong length ({data.hex(' ')}): noise, or two devices at one address"
            return Answer(doubt=doubt, state=State.GARBLED)
        distance = self._distance(data)
        if distance > self._longest:
            return Answer(doubt=f"{distance:.2f} m is farther than it listens: noise", state=State.GARBLED)
        return Answer((distance,) if distance else (), nearest=self._nearest())

    def _nearest(self) -> float:
        """How near (m) it can hear at present."""
        return 0.0

    def _read(
        self, command: int, length: int, believed: Callable[[bytes], bool]
    ) -> Course[SerialTransfer, Result[SerialTransfer]]:
        transfer = SerialTransfer(
            self._message(command), exactly(length), REPLY_WITHIN_NS, bool(self._head), framed=False
        )
        return (yield from ask_surely(transfer, believed))

    def _message(self, command: int) -> tuple[bytes | Break, ...]:
        return *self._head, bytes((self._address, command))

    def _distance(self, data: bytes) -> float:
        return int.from_bytes(data, "big") * self._metres[self._command]

    def _is_near(self, data: bytes) -> bool:
        near = self._pinged_m is not None and abs(self._distance(data) - self._pinged_m) < NEAR
        return near and self._command == self._ping
