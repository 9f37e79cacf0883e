"""Objects of a Roboteq controller asked for again and again, each at its own interval."""

from collections import Counter
from collections.abc import Mapping

from echogrid.drivers.bus import CanFrame
from echogrid.drivers.sdo import SdoAnswer, SdoClient, SdoRead
from echogrid.drivers.ticker import Ticker

LATE_NS = 30_000_000
"""A reply that comes later says too little of when its count was: the wheel has turned on."""

_EXPEDITED = 0x03


class Poll:
    """One request is open at a time. One without a reply is not repeated, as its next turn comes soon."""

    def __init__(
        self, node: int, intervals_ns: Mapping[SdoRead, int], phase_ns: int, counts: Counter[str]
    ) -> None:
        """It begins `phase_ns` after its first step."""
        self.asked_ns = 0
        """When the latest request was sent."""
        self._client = SdoClient(node, attempts=1)
        self._tickers = {read: Ticker(interval_ns) for read, interval_ns in intervals_ns.items()}
        self._phase_ns = phase_ns
        self._counts = counts

    @property
    def deadline_ns(self) -> int:
        """When to step again."""
        if not self._client.idle:
            return self._client.deadline_ns
        return min(ticker.deadline_ns for ticker in self._tickers.values())

    def forget(self) -> None:
        """Drop what is open, and begin anew."""
        self._client.forget()
        for ticker in self._tickers.values():
            ticker.stop()

    def take(self, data: bytes) -> SdoAnswer | None:
        """The answer in the 8 bytes of a reply; None if it is another's."""
        return self._client.take(_marked(data))

    def step(self, now_ns: int) -> tuple[CanFrame, ...]:
        """What is to be sent now."""
        for ticker in self._tickers.values():
            ticker.start(now_ns + self._phase_ns)
        failed, _ = self._client.step(now_ns)
        if failed is not None:
            self._counts["requests without a reply"] += 1
        if not self._client.idle:
            return ()
        read, ticker = min(self._tickers.items(), key=lambda item: item[1].deadline_ns)
        if not ticker.due(now_ns):
            return ()
        self.asked_ns = now_ns
        self._client.ask(read)
        return self._client.step(now_ns)[1]


def _marked(data: bytes) -> bytes:
    """The reply with the marks of an expedited transfer.

    The maker's own examples lack them: 581h 48 0D 21 02 90 01 00 00 (CANBus Networking Manual V2.0, p. 41).
    """
    return bytes((data[0] | _EXPEDITED, *data[1:])) if data[0] & 0xF3 == 0x40 else data
