"""Objects of a CANopen node, read and written one after the other: a client that does no input or output."""

from collections import deque
from dataclasses import dataclass

from echogrid.drivers import canopen
from echogrid.drivers.bus import NEVER_NS, CanFrame
from echogrid.drivers.canopen import Kind, SdoReply

WITHIN_NS = 300_000_000
"""So long a reply is waited for."""
ATTEMPTS = 3
"""So often a request is sent before it has failed."""


@dataclass(frozen=True, slots=True)
class SdoRead:
    """Asks for an object of up to 4 bytes."""

    index: int
    sub: int = 0


@dataclass(frozen=True, slots=True)
class SdoWrite:
    """Sets an object to 1 to 4 bytes."""

    index: int
    sub: int
    value: bytes


SdoRequest = SdoRead | SdoWrite


@dataclass(frozen=True, slots=True)
class SdoAnswer:
    """What became of a request."""

    request: SdoRequest
    reply: SdoReply | None
    """None: there was none."""

    @property
    def data(self) -> bytes:
        """What was read."""
        return self.reply.data if self.reply else b""

    @property
    def trouble(self) -> str:
        """Why it was not done, with the object; empty if it was done."""
        if self.reply is None:
            return f"{object_name(self.request)}: no reply"
        if self.reply.kind is Kind.ABORTED:
            return f"{object_name(self.request)}: {canopen.abort_name(self.reply.abort)}"
        return ""


def object_name(request: SdoRequest) -> str:
    """Index and sub-index, as in data sheets: 1A00h:1."""
    return f"{request.index:04X}h:{request.sub}"


class SdoClient:
    """Requests to one node. They wait in a queue: one is open at a time, and sent again if no reply comes.

    `ask` what is wanted, `take` every reply (a frame with the identifier SDO_REPLY + node and 8 bytes), and
    `step` until `deadline_ns`; both give the answers, in the order of the requests.
    """

    def __init__(self, node: int, attempts: int = ATTEMPTS) -> None:
        self.deadline_ns = NEVER_NS
        """When to step again."""
        self._node = node
        self._attempts = attempts
        self._waiting: deque[SdoRequest] = deque()
        self._open: SdoRequest | None = None
        self._sent = 0

    @property
    def idle(self) -> bool:
        """Whether every request has its answer."""
        return self._open is None and not self._waiting

    def ask(self, *requests: SdoRequest) -> None:
        """Do these, too; to be followed by a step."""
        self._waiting += requests
        if self._open is None and self._waiting:
            self.deadline_ns = 0

    def forget(self) -> None:
        """Drop all requests: there are no answers to them."""
        self._waiting.clear()
        self._close()

    def take(self, data: bytes) -> SdoAnswer | None:
        """The answer that a reply is; None if nobody has asked for that."""
        reply, request = canopen.decode_sdo(data), self._open
        if reply is None or request is None or not _belongs(reply, request):
            return None
        self._close()
        return SdoAnswer(request, reply)

    def step(self, now_ns: int) -> tuple[SdoAnswer | None, tuple[CanFrame, ...]]:
        """The answer to a request that got no reply, if one has failed now, and what is to be sent."""
        failed = None
        if now_ns < self.deadline_ns:
            return None, ()
        if self._open is not None and self._sent == self._attempts:
            failed = SdoAnswer(self._open, None)
            self._close()
        if self._open is None and self._waiting:
            self._open = self._waiting.popleft()
        if self._open is None:
            return failed, ()
        self._sent += 1
        self.deadline_ns = now_ns + WITHIN_NS
        return failed, (self._frame(self._open),)

    def _close(self) -> None:
        self._open, self._sent = None, 0
        self.deadline_ns = 0 if self._waiting else NEVER_NS

    def _frame(self, request: SdoRequest) -> CanFrame:
        if isinstance(request, SdoRead):
            return canopen.read_request(self._node, request.index, request.sub)
        return canopen.write_request(self._node, request.index, request.sub, request.value)


def _belongs(reply: SdoReply, request: SdoRequest) -> bool:
    """Whether it is the reply to that request: a late one to another, or to another's, is not."""
    expected = Kind.READ if isinstance(request, SdoRead) else Kind.WRITTEN
    return (reply.index, reply.sub) == (request.index, request.sub) and reply.kind in (expected, Kind.ABORTED)
