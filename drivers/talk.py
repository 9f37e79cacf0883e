"""One transfer on its way over a serial line: what was heard of it, and what comes of that."""

from errno import EIO, EPROTO, ETIMEDOUT

from echogrid.drivers.bus import Break, SerialResult, SerialTransfer

PAUSE_BYTES = 2
"""So many bytes' time of silence end a reply that does not show its end."""
LATENCY_NS = 20_000_000
"""USB adapters keep what came to themselves for up to 16 ms."""


def duration_ns(transfer: SerialTransfer, byte_ns: int) -> int:
    """How long the request takes to pass."""
    total_ns = 0
    for item in transfer.send:
        total_ns += round(item.duration_s * 1e9) if isinstance(item, Break) else len(item) * byte_ns
    return total_ns


def longest_ns(transfer: SerialTransfer, byte_ns: int) -> int:
    """The most that the transfer takes, however it ends."""
    waits_ns = transfer.within_ns + LATENCY_NS + PAUSE_BYTES * byte_ns if _waits(transfer) else 0
    return duration_ns(transfer, byte_ns) + waits_ns


class Talk:
    """From when a request goes out to its result. It is never over before the request has passed."""

    def __init__(self, transfer: SerialTransfer, now_ns: int, byte_ns: int) -> None:
        self._transfer = transfer
        self._start_ns = now_ns
        self._sent_ns = now_ns + duration_ns(transfer, byte_ns)
        self._pause_ns = PAUSE_BYTES * byte_ns
        self._own = b"".join(item for item in transfer.send if isinstance(item, bytes))
        self._heard = b""
        self._reply = b""
        self._errno = EIO if transfer.echoed else ETIMEDOUT
        """What is to be said if nothing more comes."""
        self._settled = self._looked = False
        self.deadline_ns = self._sent_ns + transfer.within_ns + LATENCY_NS
        """When to listen again, even if nothing comes."""
        if not _waits(transfer):
            self._settle(0)

    def listen(self, now_ns: int, data: bytes) -> SerialResult | None:
        """Take what has come by now; the result, if there is one.

        Time is up when a look at the port after the deadline has brought nothing more: a host that was held
        up finds there what came in time.
        """
        if data:
            self._take(now_ns, data)
        if now_ns < self.deadline_ns:
            return None
        if not (self._settled or self._looked):
            self._looked = True
            return None
        end_ns = now_ns if self._transfer.reply_length else self._sent_ns
        return SerialResult(self._transfer, self._start_ns, end_ns, self._reply, self._errno, self._sent_ns)

    def _take(self, now_ns: int, data: bytes) -> None:
        """Weigh what came behind one's own echo. A reply without a frame is whole when nothing follows it."""
        self._heard += data
        self._looked = False
        echo = self._heard.find(self._own) if self._transfer.echoed else 0
        if echo < 0:
            return
        if self._transfer.reply_length is None:
            self._settle(0)
            return
        self._reply = reply = self._heard[echo + len(self._own) :] if self._transfer.echoed else self._heard
        self._errno = EPROTO if reply else ETIMEDOUT
        length = self._transfer.reply_length(reply) if reply else 0
        if length and len(reply) > length:
            self._settle(EPROTO)
        elif length and len(reply) == length and self._transfer.framed:
            self._settle(0)
        elif length and len(reply) == length:
            self._errno = 0
            self.deadline_ns = max(self._sent_ns, now_ns + self._pause_ns)

    def _settle(self, errno: int) -> None:
        """Nothing more can change it."""
        self._errno = errno
        self._settled = True
        self.deadline_ns = self._sent_ns


def _waits(transfer: SerialTransfer) -> bool:
    """Whether something is to come back."""
    return transfer.reply_length is not None or transfer.echoed
