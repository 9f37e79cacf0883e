"""How quick a commanded ranger is, and for how long it holds its bus: what a firing plan must know of it."""

from dataclasses import dataclass
from typing import Any

from echogrid.drivers.bus import Break, I2cTransfer, Result, SerialTransfer, Transfer
from echogrid.drivers.course import Course

_I2C_BITS_PER_BYTE = 9
_SERIAL_BITS_PER_BYTE = 11
_REPLY_BYTES = 8
"""Of a reply that does not tell its length before it comes."""
_MOST_STEPS = 16
"""Of one command, or one answer."""


@dataclass(frozen=True, slots=True)
class Pace:
    """Times of one ranger, ns."""

    ping_ns: int
    """From the command to the answer."""
    rest_ns: int
    """The least from a ping to the next."""
    fire_ns: int
    """How long its bus is busy with the command."""
    collect_ns: int
    """How long its bus is busy with the answer."""
    holds_bus: bool = False
    """The answer is the reply to the command, and nothing else can go over the bus until it has come."""

    @property
    def period_ns(self) -> int:
        """How often it can fire at best, alone on its bus."""
        return max(self.rest_ns, self.fire_ns + self.ping_ns + self.collect_ns)

    @property
    def held_ns(self) -> int:
        """How long the next command on its bus has to wait for this one."""
        return self.fire_ns + (self.ping_ns if self.holds_bus else 0)


def bus_time(course: Course[Transfer, Any], idle: Transfer, bit_rate: int) -> tuple[int, Any]:
    """How long (ns) the transfers of a course take at so many bit/s, and what comes of it when all is well.

    The course is rehearsed with answers of zeros: whoever it belongs to is of no use afterwards.
    """
    busy_ns, result = 0, Result(idle, 0, 0)
    try:
        wish = next(course)
        for _ in range(_MOST_STEPS):
            if not isinstance(wish, int):
                busy_ns += _lasts_ns(wish, bit_rate)
                result = Result(wish, 0, 0, bytes(_answer_bytes(wish)))
            wish = course.send(result)
    except StopIteration as end:
        return busy_ns, end.value
    course.close()
    return busy_ns, None


def _lasts_ns(transfer: object, bit_rate: int) -> int:
    match transfer:
        case I2cTransfer(messages):
            bits = sum(_I2C_BITS_PER_BYTE * (1 + len(m.write) + m.read) + 2 for m in messages)
            return bits * 1_000_000_000 // bit_rate
        case SerialTransfer(send=items):
            count = sum(len(item) for item in items if isinstance(item, bytes)) + _answer_bytes(transfer)
            breaks_s = sum(item.duration_s for item in items if isinstance(item, Break))
            return count * _SERIAL_BITS_PER_BYTE * 1_000_000_000 // bit_rate + round(breaks_s * 1e9)
        case _:
            return 0


def _answer_bytes(transfer: object) -> int:
    match transfer:
        case I2cTransfer(messages):
            return sum(message.read for message in messages)
        case SerialTransfer(reply_length=reply_length):
            return (reply_length(bytes(_REPLY_BYTES)) or _REPLY_BYTES) if reply_length else 0
        case _:
            return 1
