"""A serial line on which devices speak when they are spoken to: one request and its reply at a time."""

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from errno import EIO, EPROTO, ETIMEDOUT

from echogrid.drivers.bus import NEVER_NS, Break, SerialResult, SerialTransfer
from echogrid.drivers.device import Device, Step
from echogrid.drivers.owed import LATE_NS, Owed
from echogrid.drivers.readings import Reading
from echogrid.drivers.talk import Talk, longest_ns

BITS_PER_BYTE = 11
"""The most: a start bit, eight of data, parity or a second stop bit, a stop bit."""
HELD_NS = 300_000_000
"""The most that a device which did not reply well waits for a gap between the others' turns."""


@dataclass(slots=True)
class _Request:
    """A transfer that a device wants."""

    transfer: SerialTransfer
    device: int
    """Its number on the line."""
    since_ns: int
    most_owed: int = 0
    """The most replies that another device owed when this was first asked."""
    replies: list[bytes] = field(default_factory=list)
    """What came of it so far; it is asked for again while that could be somebody else's."""


class Conversation:
    """The devices on one line, stepped as one, whose transfers go over it one after the other.

    What comes when nobody was asked is thrown away: without framing, a lost or an extra byte would shift all
    that follow. A device which shares the line and did not reply well is not asked again while a reply may
    still come, and then in a gap between the others' turns: it costs them nothing. Results go to the asker.
    """

    def __init__(self, name: str, devices: Sequence[Device[SerialResult, SerialTransfer]]) -> None:
        self.name = name
        self.devices = devices
        self.stray_bytes = 0
        """What came when nobody was asked."""
        self._byte_ns = _byte_ns(devices[0].port_options)
        self._deadlines_ns = [0] * len(devices)
        self._due_ns = 0
        self._waiting: deque[_Request] = deque()
        self._asked: _Request | None = None
        self._talk: Talk | None = None
        self._passed_ns = 0
        self._looks_again = False
        self._failing: dict[int, int] = {}
        """Devices which did not reply as they should when last asked, and until when they may yet."""
        self._owed = Owed()

    @property
    def counts(self) -> Mapping[str, int]:
        """What came when nobody was asked."""
        return {"stray bytes": self.stray_bytes} if self.stray_bytes else {}

    def step(self, now_ns: int, received: Sequence[bytes]) -> Step[bytes | Break]:
        """Step every device that is due, and carry its transfers."""
        readings: list[Reading] = []
        result = self._listen(now_ns, b"".join(received))
        if result and self._asked:
            self._step_device(self._asked.device, now_ns, (result,), readings)
        if now_ns >= self._due_ns:
            for number, deadline_ns in enumerate(self._deadlines_ns):
                if now_ns >= deadline_ns:
                    self._step_device(number, now_ns, (), readings)
            self._due_ns = min(self._deadlines_ns)
        send = self._begin(now_ns, came=bool(received)) if self._waiting and self._talk is None else ()
        return Step(tuple(readings), send, min(self._due_ns, self._deadline_ns(now_ns)))

    def parting(self, now_ns: int) -> Sequence[SerialTransfer]:  # noqa: ARG002 - as every line is told
        """Nothing: rangers may be left as they are."""
        return ()

    def lost(self, now_ns: int) -> None:
        """The port was lost."""
        self._waiting.clear()
        self._failing.clear()
        self._owed.clear()
        self._asked = self._talk = None
        self._looks_again = False
        for device in self.devices:
            device.lost(now_ns)
        self._deadlines_ns = [now_ns] * len(self.devices)
        self._due_ns = now_ns

    def _listen(self, now_ns: int, data: bytes) -> SerialResult | None:
        """The result of the transfer under way, if it has one now."""
        if self._talk is None or self._asked is None:
            if data:
                self.stray_bytes += len(data)
                self._passed_ns = now_ns
            return None
        result = self._talk.listen(now_ns, data)
        if result is None:
            return None
        self._talk = None
        self._passed_ns = result.end_ns
        return self._judged(self._asked, result, now_ns) if self._asked.transfer.reply_length else result

    def _judged(self, asked: _Request, result: SerialResult, now_ns: int) -> SerialResult | None:
        """The result as it is to be taken; None if it is to be asked for again.

        A reply without a frame must come as often as shows that no other one's late replies are taken for it.
        """
        if not result.errno and not asked.transfer.framed:
            asked.replies.append(result.data)
            if len(set(asked.replies)) > 1:
                result = replace(result, errno=EPROTO, data=b"".join(asked.replies))
            elif len(asked.replies) <= asked.most_owed:
                self._waiting.appendleft(asked)
                return None
        if result.errno == 0:
            self._failing.pop(asked.device, None)
        elif len(self.devices) > 1:
            owes = result.errno in (ETIMEDOUT, EIO) or bool(asked.replies)
            self._failing[asked.device] = now_ns + LATE_NS if owes else now_ns
            self._owed.add(asked.device, 1 + len(asked.replies) if owes else 0, now_ns)
        return result

    def _step_device(
        self, number: int, now_ns: int, results: tuple[SerialResult, ...], readings: list[Reading]
    ) -> None:
        step = self.devices[number].step(now_ns, results)
        readings += step.readings
        self._deadlines_ns[number] = step.deadline_ns
        self._due_ns = min(self._due_ns, step.deadline_ns)
        self._waiting.extend(_Request(transfer, number, now_ns) for transfer in step.send)

    def _begin(self, now_ns: int, came: bool) -> tuple[bytes | Break, ...]:
        """What is to be sent, if it is time for the next transfer.

        When something has just come the port is looked at once more: what else is there is no reply to this.
        """
        self._looks_again = came and not self._looks_again
        request = self._next()
        if self._looks_again or self._from_ns(request, now_ns) > now_ns:
            return ()
        self._waiting.remove(request)
        if not request.replies:
            request.most_owed = self._owed.most(now_ns)
        self._asked, self._talk = request, Talk(request.transfer, now_ns, self._byte_ns)
        return request.transfer.send

    def _deadline_ns(self, now_ns: int) -> int:
        """When the line itself is to be seen to."""
        if self._talk:
            return self._talk.deadline_ns
        if self._looks_again:
            return now_ns
        return self._from_ns(self._next(), now_ns) if self._waiting else NEVER_NS

    def _next(self) -> _Request:
        """The request whose turn it is: what fires before what collects, what may find nobody last."""
        return min(self._waiting, key=self._rank) if len(self._waiting) > 1 else self._waiting[0]

    def _rank(self, request: _Request) -> int:
        if request.transfer.reply_length is None:
            return 0
        return 2 if self._stands_back(request) else 1

    def _stands_back(self, request: _Request) -> bool:
        asks_first = request.transfer.reply_length is not None and not request.replies
        return asks_first and request.device in self._failing

    def _from_ns(self, request: _Request, now_ns: int) -> int:
        """From when on a request may go out, as far as is known now."""
        free_ns = self._passed_ns + request.transfer.quiet_ns
        if not self._stands_back(request):
            return free_ns
        since_ns = max(request.since_ns, self._failing[request.device])
        free_ns = max(free_ns, since_ns)
        in_turn = (due_ns for number, due_ns in enumerate(self._deadlines_ns) if number not in self._failing)
        gap_ends_ns = min(in_turn, default=NEVER_NS)
        if max(free_ns, now_ns) + longest_ns(request.transfer, self._byte_ns) <= gap_ends_ns:
            return free_ns
        return max(free_ns, since_ns + HELD_NS)


def _byte_ns(port_options: Mapping[str, object]) -> int:
    """How long a byte takes at most, by what the devices want of their port; they are of one mind."""
    baud = port_options.get("baud", 9600)
    return BITS_PER_BYTE * 1_000_000_000 // (baud if isinstance(baud, int) else 9600)
