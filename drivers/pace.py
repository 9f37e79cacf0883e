"""How quick a commanded ranger is, and for how long it holds its bus: what a firing plan must know of it."""

from dataclasses import dataclass
from typing import Any

from echogrid.drivers.bus import Break, I2cTransfer, Result, SerialResult, SerialTransfer
from echogrid.drivers.course import Course
from echogrid.drivers.make import Fired, Make

TURNAROUND_NS = 2_000_000
"""From a request to the reply's first byte, besides what the transfer itself prescribes: unknown of most, an
allowance."""
_I2C_BITS_PER_BYTE = 9
_SERIAL_BITS_PER_BYTE = 11
_REPLY_BYTES = 8
"""Of a reply that does not tell its length before it comes."""
_PAUSE_BYTES = 2
"""So many bytes' time of silence end a reply without a frame."""
_READY = b"\1"
"""What is read of a device that has done; zeros are what some read while they ping."""
_MOST_STEPS = 16
"""Of one command, or one answer."""
_ANSWERS = 16
"""Of so many the one counts that takes longest: there are makes which do more with every so many."""

Span = tuple[int, int]
"""From when to when, ns."""


@dataclass(frozen=True, slots=True)
class Pace:
    """Times of one ranger, ns."""

    ping_ns: int
    """From the ping to the answer."""
    rest_ns: int
    """The least from a ping to the next."""
    fire_ns: int
    """How long its bus is busy with the command, at most."""
    collect_ns: int
    """How long its bus is busy with the answer, at most."""
    holds_bus: bool = False
    """The answer is the reply to the command, and nothing else can go over the bus until it has come."""
    pinged_ns: int = 0
    """From the command's beginning to the ping, by which the answer is waited for; at most."""
    looks: tuple[Span, ...] = ()
    """When it needs its bus while it pings, from the command's beginning on; at the latest."""

    @property
    def period_ns(self) -> int:
        """How often it can fire at best, alone on its bus."""
        return max(self.rest_ns, self.fire_ns + self.ping_ns + self.collect_ns)

    @property
    def held_ns(self) -> int:
        """How long the next command on its bus has to wait for this one."""
        return self.fire_ns + (self.ping_ns if self.holds_bus else 0)

    @property
    def carried_ns(self) -> int:
        """How long its bus is busy with all that belongs to one ping."""
        return self.held_ns + self.collect_ns + sum(end_ns - start_ns for start_ns, end_ns in self.looks)

    @property
    def busy(self) -> tuple[Span, ...]:
        """When it needs its bus, from its turn on: for the command, and then for the answer.

        Bytes are shorter than they are reckoned, and devices quicker: so all that follows the ping may come
        earlier, by a third of the time to the ping.
        """
        answered_ns = self.pinged_ns + self.ping_ns
        later = (*self.looks, (answered_ns, answered_ns + self.collect_ns))
        early_ns = self.pinged_ns // 3
        spans = ((start_ns - early_ns, end_ns) for start_ns, end_ns in later if end_ns > start_ns)
        return ((0, self.held_ns), *spans)


def pace_of(make: Make[Any], bit_rate: int) -> Pace:
    """How quick a make is on a bus of so many bit/s, by a rehearsal: it believes that it has pinged."""
    command = Rehearsal(make.idle, bit_rate)
    fired = command.play(make.fire(listens=False))
    pinged_ns = fired.stamp_ns if isinstance(fired, Fired) else command.busy_ns
    if isinstance(fired, Fired) and fired.data:
        return Pace(make.ping_ns, make.rest_ns, command.busy_ns, 0, holds_bus=True, pinged_ns=pinged_ns)
    meanwhile, answer = Rehearsal(make.idle, bit_rate), Rehearsal(make.idle, bit_rate)
    meanwhile.play(make.meanwhile())
    collect_ns = 0
    for _ in range(_ANSWERS):
        answer = Rehearsal(make.idle, bit_rate)
        answer.play(make.collect())
        collect_ns = max(collect_ns, answer.busy_ns)
    looks = tuple(meanwhile.spans)
    return Pace(make.ping_ns, make.rest_ns, command.busy_ns, collect_ns, False, pinged_ns, looks)


class Rehearsal:
    """A bus on which all is well, from the time 0 on: what courses do there, and when."""

    def __init__(self, idle: object, bit_rate: int) -> None:
        """`idle` stands for the transfer before the first."""
        self.spans: list[Span] = []
        """When the bus was busy."""
        self._result: Result[Any] = Result(idle, 0, 0)
        self._bit_rate = bit_rate
        self._now_ns = 0

    @property
    def busy_ns(self) -> int:
        """For how long the bus was busy."""
        return sum(end_ns - start_ns for start_ns, end_ns in self.spans)

    def play(self, course: Course[Any, Any]) -> Any:
        """What comes of a course; None if it never ends."""
        try:
            wish = next(course)
            for _ in range(_MOST_STEPS):
                if isinstance(wish, int):
                    self._now_ns = max(self._now_ns, wish)
                else:
                    self._carry(wish)
                wish = course.send(self._result)
        except StopIteration as end:
            return end.value
        course.close()
        return None

    def _carry(self, transfer: object) -> None:
        self._result = _carried(transfer, self._now_ns, self._bit_rate)
        start_ns, self._now_ns = self._now_ns, self._result.end_ns + _quiet_ns(transfer)
        self.spans.append((start_ns, self._now_ns))


def _carried(transfer: Any, start_ns: int, bit_rate: int) -> Result[Any]:
    """The result of a transfer that begins at that time."""
    match transfer:
        case I2cTransfer(messages):
            answer = _READY * sum(message.read for message in messages)
            bits = sum(_I2C_BITS_PER_BYTE * (1 + len(m.write) + m.read) + 2 for m in messages)
            return Result(transfer, start_ns, start_ns + bits * 1_000_000_000 // bit_rate, answer)
        case SerialTransfer(send=items):
            answer = bytes(_reply_bytes(transfer))
            byte_ns = _SERIAL_BITS_PER_BYTE * 1_000_000_000 // bit_rate
            breaks_s = sum(item.duration_s for item in items if isinstance(item, Break))
            sent = sum(len(item) for item in items if isinstance(item, bytes))
            sent_ns = start_ns + sent * byte_ns + round(breaks_s * 1e9)
            end_ns = sent_ns + _reply_ns(transfer, len(answer), byte_ns)
            return SerialResult(transfer, start_ns, end_ns, answer, sent_ns=sent_ns)
        case _:
            return Result(transfer, start_ns, start_ns, _READY)


def _reply_ns(transfer: SerialTransfer, length: int, byte_ns: int) -> int:
    """From a request's end, which is a silence where one is needed, to that of its reply."""
    if transfer.reply_length is None:
        return 0
    pause_ns = 0 if transfer.framed else _PAUSE_BYTES * byte_ns
    return transfer.quiet_ns + TURNAROUND_NS + length * byte_ns + pause_ns


def _quiet_ns(transfer: object) -> int:
    """How long nothing may be sent behind it."""
    return transfer.quiet_ns if isinstance(transfer, SerialTransfer) else 0


def _reply_bytes(transfer: SerialTransfer) -> int:
    """How long its reply will be."""
    if transfer.reply_length is None:
        return 0
    return transfer.reply_length(bytes(_REPLY_BYTES)) or _REPLY_BYTES
