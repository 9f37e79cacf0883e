"""The PDOs of an emulated CANopen node: what is in them, when they are sent, and who may change that."""

from collections.abc import Iterator

from echogrid.drivers.bus import NEVER_NS
from echogrid.emulation.devices.canopen_objects import (
    INVALID_VALUE,
    NOT_MAPPABLE,
    PDO_TOO_LONG,
    UNSUPPORTED,
    AbortError,
    Dictionary,
    Item,
    Key,
)

_OFF = 1 << 31
_MOST_ENTRIES = 8
_FRAME_BITS = 64
_EVENT_TYPES = (254, 255)
_BY_SYNC = 240
"""The highest type that counts SYNCs."""
_INHIBIT_NS = 100_000


class Pdo:
    """One of them; its settings and its mapping are objects."""

    def __init__(
        self, dictionary: Dictionary, settings: int, identifier: int, mapped: tuple[Key, ...]
    ) -> None:
        """`settings` is the index of its settings, 0x1400 or 0x1800 and up."""
        self.settings = settings
        self._dictionary = dictionary
        self._mapping = settings + 0x200
        dictionary.add(self._settings_items(identifier) | self._mapping_items(mapped))

    @property
    def on(self) -> bool:
        """Whether it is in use."""
        return not self._dictionary.value(self.settings, 1) & _OFF

    @property
    def identifier(self) -> int:
        """Of its frame."""
        return self._dictionary.value(self.settings, 1) & 0x7FF

    @property
    def type(self) -> int:
        """Its transmission type."""
        return self._dictionary.value(self.settings, 2)

    @property
    def inhibit_ns(self) -> int:
        """From one to the next at the least, if it is sent by event."""
        return self._dictionary.value(self.settings, 3) * _INHIBIT_NS

    @property
    def event_ns(self) -> int:
        """From one to the next at the most, if it is sent by event; 0: any time."""
        return self._dictionary.value(self.settings, 5) * 1_000_000

    def keys(self) -> Iterator[Key]:
        """The objects in it."""
        for sub in range(1, self._dictionary.value(self._mapping, 0) + 1):
            entry = self._dictionary.value(self._mapping, sub)
            yield entry >> 16, entry >> 8 & 0xFF

    def packed(self, now_ns: int) -> bytes:
        """What it says now."""
        return b"".join(self._dictionary.item(*key).packed(now_ns) for key in self.keys())

    def unpack(self, data: bytes, now_ns: int) -> bool:
        """Take what it says; whether it was long enough."""
        lengths = [self._dictionary.item(*key).length for key in self.keys()]
        if len(data) < sum(lengths):
            return False
        for key, length in zip(self.keys(), lengths, strict=True):
            self._dictionary.item(*key).store(data[:length], now_ns)
            data = data[length:]
        return True

    def _settings_items(self, identifier: int) -> dict[Key, Item]:
        return {
            (self.settings, 0): Item("B", 5, writable=False),
            (self.settings, 1): Item("I", identifier, written=self._identified),
            (self.settings, 2): Item("B", 255, written=self._typed),
            (self.settings, 3): Item("H", 0, written=self._only_off),
            (self.settings, 5): Item("H", 0),
        }

    def _mapping_items(self, mapped: tuple[Key, ...]) -> dict[Key, Item]:
        entries = [self._entry(key) for key in mapped]
        entries += [0] * (_MOST_ENTRIES - len(entries))
        items = {
            (self._mapping, sub): Item("I", entry, written=self._mapped)
            for sub, entry in enumerate(entries, 1)
        }
        return {(self._mapping, 0): Item("B", len(mapped), written=self._counted), **items}

    def _entry(self, key: Key) -> int:
        return key[0] << 16 | key[1] << 8 | 8 * self._dictionary.item(*key).length

    def _identified(self, value: int, now_ns: int) -> None:
        del now_ns
        if self.on and not value & _OFF and value & 0x7FF != self.identifier:
            raise AbortError(INVALID_VALUE)

    def _typed(self, value: int, now_ns: int) -> None:
        del now_ns
        if not (1 <= value <= _BY_SYNC or value in _EVENT_TYPES):
            raise AbortError(INVALID_VALUE)

    def _only_off(self, value: int, now_ns: int) -> None:
        del value, now_ns
        if self.on:
            raise AbortError(UNSUPPORTED)

    def _mapped(self, value: int, now_ns: int) -> None:
        self._only_off(value, now_ns)
        if self._dictionary.value(self._mapping, 0):
            raise AbortError(UNSUPPORTED)
        item = self._dictionary.item(value >> 16, value >> 8 & 0xFF)
        if not item.mappable or value & 0xFF != 8 * item.length:
            raise AbortError(NOT_MAPPABLE)

    def _counted(self, value: int, now_ns: int) -> None:
        self._only_off(value, now_ns)
        if value > _MOST_ENTRIES:
            raise AbortError(INVALID_VALUE)
        entries = [self._dictionary.value(self._mapping, sub) for sub in range(1, value + 1)]
        if not all(entries):
            raise AbortError(NOT_MAPPABLE)
        if sum(entry & 0xFF for entry in entries) > _FRAME_BITS:
            raise AbortError(PDO_TOO_LONG)


class Sending:
    """When a PDO of the node is due."""

    def __init__(self, pdo: Pdo) -> None:
        self.pdo = pdo
        self._due_ns = NEVER_NS
        self._free_ns = 0
        self._syncs = 0

    def due_ns(self) -> int:
        """When it is sent without a SYNC; NEVER_NS if only that makes it."""
        return self._due_ns if self.pdo.on and self.pdo.type > _BY_SYNC else NEVER_NS

    def sent(self, now_ns: int) -> None:
        """It was sent."""
        self._free_ns = now_ns + self.pdo.inhibit_ns
        self.settle(now_ns)

    def settle(self, now_ns: int) -> None:
        """Begin its time anew, by its settings as they are now."""
        self._due_ns = max(now_ns + self.pdo.event_ns, self._free_ns) if self.pdo.event_ns else NEVER_NS

    def want(self, now_ns: int) -> None:
        """Something in it has changed."""
        self._due_ns = min(self._due_ns, max(now_ns, self._free_ns))

    def restart(self, now_ns: int) -> None:
        """The node has become operational: what is sent by event is sent at once."""
        self._due_ns, self._free_ns, self._syncs = now_ns, now_ns, 0

    def synchronised(self) -> bool:
        """Whether a SYNC that has come is its own: each nth, by its type."""
        if not self.pdo.on or self.pdo.type > _BY_SYNC:
            return False
        self._syncs = (self._syncs + 1) % self.pdo.type
        return self._syncs == 0
