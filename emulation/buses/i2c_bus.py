"""An emulated I2C bus: transfers one after the other, nine bits a byte."""

from collections import deque
from collections.abc import Sequence
from errno import ENXIO
from functools import reduce

from echogrid.drivers.bus import NEVER_NS, I2cMessage, I2cResult, I2cTransfer
from echogrid.emulation.buses.bus import PoweringBus
from echogrid.emulation.devices.i2c_chip import I2cChip

_GENERAL_CALL = 0


class I2cBus(PoweringBus[I2cResult, I2cTransfer]):
    """A missing acknowledge ends the transfer with ENXIO. A result is there when its transfer has ended."""

    def __init__(self, name: str, bit_rate: int, chips: Sequence[I2cChip]) -> None:
        super().__init__(name, chips)
        self._byte_ns = 9 * 1_000_000_000 // bit_rate
        self._chips = chips
        self._waiting: deque[I2cTransfer] = deque()
        self._on_wire: I2cResult | None = None
        self._received: list[I2cResult] = []

    def has_received(self) -> bool:
        """Whether results wait to be taken."""
        return bool(self._received)

    def _send(self, items: Sequence[I2cTransfer], now_ns: int) -> None:
        """Begin transfers, each when the one before has ended."""
        self._waiting.extend(items)
        self._begin_next(now_ns)

    def _take(self) -> tuple[I2cResult, ...]:
        """The results of the transfers that have ended by now."""
        results = tuple(self._received)
        self._received.clear()
        return results

    def _drop(self) -> None:
        self._waiting.clear()
        self._on_wire = None
        self._received.clear()

    def _next_ns(self) -> int:
        end_ns = self._on_wire.end_ns if self._on_wire else NEVER_NS
        return min((end_ns, *(chip.next_event_ns() for chip in self._chips)))

    def _step(self, now_ns: int) -> None:
        for chip in self._chips:
            chip.advance(now_ns)
        if self._on_wire and now_ns >= self._on_wire.end_ns:
            self._received.append(self._on_wire)
            self._on_wire = None
            self._begin_next(now_ns)

    def _begin_next(self, now_ns: int) -> None:
        if self._on_wire is None and self._waiting:
            self._on_wire = self._carry_out(self._waiting.popleft(), now_ns)

    def _carry_out(self, transfer: I2cTransfer, start_ns: int) -> I2cResult:
        data = b""
        now_ns = start_ns
        for message in transfer.messages:
            chips = self._addressed(message, now_ns)
            if not chips:
                return I2cResult(transfer, start_ns, now_ns + self._byte_ns, errno=ENXIO)
            end_ns = now_ns + (1 + len(message.write) + message.read) * self._byte_ns
            if message.read:
                data += _pulled_down([chip.read(message.read) for chip in chips])
            else:
                for chip in chips:
                    chip.write(message.write, end_ns)
            now_ns = end_ns
        return I2cResult(transfer, start_ns, now_ns, data)

    def _addressed(self, message: I2cMessage, now_ns: int) -> list[I2cChip]:
        """The chips which acknowledge the message."""
        general = message.address == _GENERAL_CALL and not message.read
        return [
            chip
            for chip in self._chips
            if (chip.takes_general_call if general else chip.address == message.address)
            and chip.acknowledges(now_ns)
        ]


def _pulled_down(answers: Sequence[bytes]) -> bytes:
    """What the host reads when several drive the line at once: each can pull it down, and none up."""
    return bytes(reduce(int.__and__, together) for together in zip(*answers, strict=True))
