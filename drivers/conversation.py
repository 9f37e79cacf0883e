"""A serial line on which devices speak when they are spoken to: one request and its reply at a time."""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from errno import EIO, EPROTO, ETIMEDOUT

from echogrid.drivers.bus import NEVER_NS, Break, SerialResult, SerialTransfer
from echogrid.drivers.device import Device, Line, Step
from echogrid.drivers.readings import Reading

BITS_PER_BYTE = 11
"""The most: a start bit, eight of data, parity or a second stop bit, a stop bit."""
PAUSE_BYTES = 3
"""So many bytes' time of silence end a reply that does not show its end."""
SLACK_NS = 2_000_000
"""For the host's own buffers."""


@dataclass(slots=True)
class _Talk:
    """The transfer under way."""

    transfer: SerialTransfer
    start_ns: int
    sent_ns: int
    """When the request has passed."""
    deadline_ns: int
    heard: bytearray = field(default_factory=bytearray)


class Conversation:
    """The devices on one line, stepped as one, whose transfers go over it one after the other.

    What comes before a request is thrown away, and so is a reply that comes too late: without framing a lost
    or an extra byte would shift all that follow.
    """

    def __init__(self, name: str, devices: Sequence[Device[SerialResult, SerialTransfer]]) -> None:
        self.name = name
        self.devices = devices
        self._line = Line(name, devices)
        self._byte_ns = BITS_PER_BYTE * 1_000_000_000 // _baud(devices)
        self._waiting: deque[SerialTransfer] = deque()
        self._talk: _Talk | None = None
        self._due_ns = 0
        self.stray_bytes = 0

    def step(self, now_ns: int, received: Sequence[bytes]) -> Step[bytes | Break]:
        """Step every device that is due, and carry its transfers."""
        results = self._listen(now_ns, b"".join(received))
        readings: list[Reading] = []
        send: list[bytes | Break] = []
        while True:
            step = self._line.step(now_ns, results)
            readings += step.readings
            self._waiting.extend(step.send)
            self._due_ns = step.deadline_ns
            if self._talk is None and self._waiting:
                send += self._begin(now_ns, self._waiting.popleft())
            results = self._listen(now_ns, b"")
            if not results:
                return Step(tuple(readings), tuple(send), min(self._due_ns, self._deadline_ns()))

    def lost(self, now_ns: int) -> None:
        """The port was lost."""
        self._waiting.clear()
        self._talk = None
        self._line.lost(now_ns)

    def _begin(self, now_ns: int, transfer: SerialTransfer) -> tuple[bytes | Break, ...]:
        sent_ns = now_ns + sum(self._duration_ns(item) for item in transfer.send)
        wait_ns = transfer.within_ns + SLACK_NS if transfer.reply_length or transfer.echoed else 0
        self._talk = _Talk(transfer, now_ns, sent_ns, sent_ns + wait_ns)
        return transfer.send

    def _listen(self, now_ns: int, data: bytes) -> list[SerialResult]:
        """The result of the transfer under way, if it has one now."""
        talk = self._talk
        if talk is None:
            self.stray_bytes += len(data)
            return []
        if data:
            talk.heard += data
            if not talk.transfer.framed:
                talk.deadline_ns = max(talk.sent_ns, now_ns) + self._patience_ns(talk)
        ended = self._ended(talk, now_ns)
        if ended is None:
            return []
        self._talk = None
        errno, reply = ended
        end_ns = now_ns if talk.transfer.reply_length else talk.sent_ns
        return [SerialResult(talk.transfer, talk.start_ns, end_ns, reply, errno, talk.sent_ns)]

    def _ended(self, talk: _Talk, now_ns: int) -> tuple[int, bytes] | None:
        """errno and reply, if the transfer is over."""
        reply, over = self._reply(talk), now_ns >= talk.deadline_ns
        if reply is None:
            return (EIO, b"") if over else None
        if talk.transfer.reply_length is None:
            return (0, b"") if over or talk.transfer.echoed else None
        length = talk.transfer.reply_length(reply) if reply else 0
        if length and len(reply) > length:
            return EPROTO, reply
        if length and len(reply) == length and (talk.transfer.framed or over):
            return 0, reply
        if over:
            return (EPROTO if reply else ETIMEDOUT), reply
        return None

    def _reply(self, talk: _Talk) -> bytes | None:
        """What has come behind one's own echo; None while that is not complete."""
        heard = bytes(talk.heard)
        if not talk.transfer.echoed:
            return heard
        own = b"".join(item for item in talk.transfer.send if isinstance(item, bytes))
        found = heard.find(own)
        return None if found < 0 else heard[found + len(own) :]

    def _patience_ns(self, talk: _Talk) -> int:
        """How much longer to wait behind a byte of a reply that does not show its end."""
        reply = self._reply(talk)
        return PAUSE_BYTES * self._byte_ns + SLACK_NS if reply else talk.transfer.within_ns + SLACK_NS

    def _deadline_ns(self) -> int:
        return self._talk.deadline_ns if self._talk else NEVER_NS

    def _duration_ns(self, item: bytes | Break) -> int:
        if isinstance(item, Break):
            return round(item.duration_s * 1e9)
        return len(item) * self._byte_ns


def _baud(devices: Sequence[Device[SerialResult, SerialTransfer]]) -> int:
    """What the devices want; they are of one mind."""
    baud = devices[0].port_options.get("baud", 9600)
    return baud if isinstance(baud, int) else 9600
