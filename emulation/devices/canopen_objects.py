"""The object dictionary of an emulated CANopen node, and the server through which others get at it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from struct import Struct

Key = tuple[int, int]
"""Index and sub-index."""

NO_OBJECT, NO_SUB_INDEX = 0x06020000, 0x06090011
WRITE_ONLY, READ_ONLY, UNSUPPORTED = 0x06010001, 0x06010002, 0x06010000
TOO_LONG, TOO_SHORT, INVALID_VALUE = 0x06070012, 0x06070013, 0x06090030
NOT_MAPPABLE, PDO_TOO_LONG = 0x06040041, 0x06040042
UNKNOWN_COMMAND = 0x05040001


class AbortError(Exception):
    """A request that is refused."""

    def __init__(self, code: int) -> None:
        super().__init__(f"{code:#010x}")
        self.code = code


@dataclass(slots=True)
class Item:
    """One object. Its form is one letter of the struct module: B H I b h i."""

    form: str
    value: int = 0
    writable: bool = True
    mappable: bool = False
    read: Callable[[int], int] | None = None
    """Gives the value at a time (ns), if that changes by itself."""
    written: Callable[[int, int], None] | None = None
    """Called with value and time before it is kept; may raise Abort."""

    @property
    def length(self) -> int:
        """Bytes."""
        return Struct(f"<{self.form}").size

    def packed(self, now_ns: int) -> bytes:
        """Its bytes at that time."""
        return Struct(f"<{self.form}").pack(self.read(now_ns) if self.read else self.value)

    def store(self, data: bytes, now_ns: int) -> None:
        """Take a value of the right length. Raises Abort if it can't be."""
        (value,) = Struct(f"<{self.form}").unpack(data)
        if self.written:
            self.written(value, now_ns)
        self.value = value


class Dictionary:
    """Objects by index and sub-index."""

    def __init__(self) -> None:
        self._items: dict[Key, Item] = {}
        self._defaults: dict[Key, int] = {}

    def add(self, items: Mapping[Key, Item]) -> None:
        """Have these, too; their values are those after power-up."""
        self._items |= items
        self._defaults |= {key: item.value for key, item in items.items()}

    def reset(self) -> None:
        """Everything as after power-up."""
        for key, value in self._defaults.items():
            self._items[key].value = value

    def item(self, index: int, sub: int) -> Item:
        """One object. Raises Abort if there is none."""
        if (index, sub) in self._items:
            return self._items[index, sub]
        raise AbortError(NO_SUB_INDEX if any(key[0] == index for key in self._items) else NO_OBJECT)

    def value(self, index: int, sub: int = 0) -> int:
        """What is kept in an object."""
        return self._items[index, sub].value

    def write(self, key: Key, data: bytes, now_ns: int) -> None:
        """Set an object from outside. Raises Abort."""
        item = self.item(*key)
        if not item.writable:
            raise AbortError(READ_ONLY)
        if len(data) != item.length:
            raise AbortError(TOO_LONG if len(data) > item.length else TOO_SHORT)
        item.store(data, now_ns)

    def serve(self, request: bytes, now_ns: int) -> bytes | None:
        """The 8 bytes of the reply to 8 bytes; only expedited transfers are done."""
        command, address = request[0], request[1:4]
        index, sub = int.from_bytes(address[:2], "little"), address[2]
        if command >> 5 == 4:
            return None
        try:
            if command >> 5 == 2:
                data = self.item(index, sub).packed(now_ns)
                return bytes((0x43 | 4 - len(data) << 2, *address)) + data.ljust(4, b"\0")
            if command >> 5 == 1 and command & 2:
                length = 4 - (command >> 2 & 3) if command & 1 else self.item(index, sub).length
                self.write((index, sub), request[4 : 4 + length], now_ns)
                return bytes((0x60, *address)) + bytes(4)
            raise AbortError(UNKNOWN_COMMAND)
        except AbortError as abort:
            return bytes((0x80, *address)) + abort.code.to_bytes(4, "little")
