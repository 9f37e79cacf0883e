"""An emulated CAN bus: one frame at a time, the lowest identifier first."""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, replace

from echogrid.drivers.bus import NEVER_NS, CanFrame
from echogrid.emulation.buses.bus import Bus
from echogrid.emulation.devices.can_node import CanNode

_KEPT = 4096
"""Frames that wait for the host; the oldest are lost."""
_STANDARD_BITS, _EXTENDED_BITS = 47, 67
"""A frame without data, with the space to the next one and without stuff bits."""
_FD_STANDARD_BITS, _FD_EXTENDED_BITS = 29, 48
"""Those of a CAN-FD frame that take their time at the bit rate, and not at that of its data."""
_FD_SHORT_BITS, _FD_LONG_BITS = 33, 38
"""The others but its data, with the fixed stuff bits; the checksum is longer with more than 16 bytes."""
_DATA_RATE = 5_000_000


@dataclass(frozen=True, slots=True)
class _Bid:
    """A frame that somebody wants to send."""

    frame: CanFrame
    sender: CanNode | None
    """None: the host."""

    def priority(self) -> tuple[int, bool, bool]:
        """What arbitration compares: the lowest wins."""
        frame = self.frame
        return frame.identifier << (0 if frame.extended else 18), frame.extended, frame.remote


class CanBus(Bus[CanFrame, CanFrame]):
    """The nodes have a supply of their own: they go on when the host's adapter is unplugged.

    Every frame is acknowledged, and there are no error frames: nodes that don't know CAN-FD pass its frames
    over, where real ones would destroy them.
    """

    def __init__(
        self, name: str, bit_rate: int, nodes: Sequence[CanNode], data_rate: int = _DATA_RATE
    ) -> None:
        """`data_rate` is that of the data in CAN-FD frames."""
        super().__init__(name, nodes)
        self.bit_rate = bit_rate
        self.fd = any(node.fd for node in nodes)
        """Whether a node speaks CAN-FD."""
        self._data_rate = data_rate
        self._nodes = nodes
        self._bids: list[_Bid] = []
        self._on_wire: _Bid | None = None
        self._wire_free_ns = NEVER_NS
        self._received: deque[CanFrame] = deque(maxlen=_KEPT)

    def has_received(self) -> bool:
        """Whether frames wait to be taken."""
        return bool(self._received)

    def _send(self, items: Sequence[CanFrame], now_ns: int) -> None:
        """Send frames from the host, when the bus is free for them."""
        self._bids += [_Bid(frame, None) for frame in items]
        self._arbitrate(now_ns)

    def _take(self) -> tuple[CanFrame, ...]:
        """The frames that have come by now, each stamped with its end."""
        frames = tuple(self._received)
        self._received.clear()
        return frames

    def _drop(self) -> None:
        self._bids = [bid for bid in self._bids if bid.sender is not None]
        self._received.clear()

    def _next_ns(self) -> int:
        due_ns = self._wire_free_ns
        for node in self._nodes:
            due_ns = min(due_ns, node.next_event_ns(), node.next_send_ns())
        return due_ns

    def _step(self, now_ns: int) -> None:
        if self._on_wire and now_ns >= self._wire_free_ns:
            self._deliver(self._on_wire)
        for node in self._nodes:
            node.advance(now_ns)
            self._bids += [_Bid(frame, node) for frame in node.take(now_ns) if node.has_contact(now_ns)]
        self._arbitrate(now_ns)

    def _deliver(self, bid: _Bid) -> None:
        end_ns = self._wire_free_ns
        self._on_wire, self._wire_free_ns = None, NEVER_NS
        if bid.sender is not None and self.present:
            self._received.append(replace(bid.frame, stamp_ns=end_ns))
        for node in self._nodes:
            understood = node.fd or not bid.frame.fd
            if understood and node is not bid.sender and node.has_contact(end_ns):
                node.receive(bid.frame, end_ns)

    def _contenders(self) -> list[_Bid]:
        """A node's frames compete among themselves, too; the host, as Linux does, sends in its own order."""
        hosts = next((bid for bid in self._bids if bid.sender is None), None)
        return [bid for bid in self._bids if bid.sender is not None or bid is hosts]

    def _arbitrate(self, now_ns: int) -> None:
        if self._on_wire or not self._bids:
            return
        self._on_wire = min(self._contenders(), key=_Bid.priority)
        self._bids.remove(self._on_wire)
        self._wire_free_ns = now_ns + frame_time_ns(self._on_wire.frame, self.bit_rate, self._data_rate)


def frame_time_ns(frame: CanFrame, bit_rate: int, data_rate: int) -> int:
    """How long a frame takes on the wire."""
    if frame.fd:
        slow = _FD_EXTENDED_BITS if frame.extended else _FD_STANDARD_BITS
        fast = (_FD_SHORT_BITS if len(frame.data) <= 16 else _FD_LONG_BITS) + 8 * len(frame.data)
        return slow * 1_000_000_000 // bit_rate + fast * 1_000_000_000 // data_rate
    bits = (_EXTENDED_BITS if frame.extended else _STANDARD_BITS) + 8 * len(frame.data)
    return bits * 1_000_000_000 // bit_rate
