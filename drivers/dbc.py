"""Signals described by a DBC file, turned into tables once, so that no frame is decoded by a library."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from difflib import get_close_matches
from pathlib import Path
from struct import Struct
from typing import TYPE_CHECKING, Literal, TypeVar

if TYPE_CHECKING:
    from cantools.database.can import Message

T = TypeVar("T")

FLOATS = {16: Struct(">e"), 32: Struct(">f"), 64: Struct(">d")}
"""IEEE 754, by bits."""
LONGEST = 8
"""Bytes of a classic frame."""
MOST_NAMED = 12
"""Names in a message."""


@dataclass(frozen=True, slots=True)
class Signal:
    """Where a number lies in which frame, and what its steps are."""

    identifier: int
    extended: bool
    length: int
    """Bytes of the frame; what is longer is a later edition of it, what is shorter is none."""
    byte_order: Literal["little", "big"]
    shift: int
    """Bits below it, when the frame is read as one integer in that order."""
    bits: int
    signed: bool
    floating: bool
    factor: float
    offset: float

    def raw(self, data: bytes) -> int | float:
        """The number in a frame's data of `length` bytes or more."""
        pattern = int.from_bytes(data[: self.length], self.byte_order) >> self.shift & (1 << self.bits) - 1
        if self.floating:
            number: float = FLOATS[self.bits].unpack(pattern.to_bytes(self.bits // 8, "big"))[0]
            return number
        if self.signed and pattern >> self.bits - 1:
            return pattern - (1 << self.bits)
        return pattern

    def value(self, data: bytes) -> float:
        """The same in the file's unit."""
        return self.raw(data) * self.factor + self.offset

    def with_sign(self, signed: bool | None) -> "Signal":
        """The same with a sign, or without one; None: as in the file."""
        return self if signed is None else replace(self, signed=signed)


def load_signals(file: str, names: Iterable[str]) -> list[Signal]:
    """The signals of these names, each "Message.Signal". Raises ValueError, which says what is wrong."""
    messages = {message.name: message for message in _messages(file)}
    return [_signal(messages, name) for name in names]


def _messages(file: str) -> Iterable["Message"]:
    try:
        import cantools
    except ImportError as error:
        raise ValueError("a DBC file is read by cantools, which is missing: pip install cantools") from error
    try:
        text = Path(file).read_text(encoding="cp1252", errors="replace")
    except OSError as error:
        why = error.strerror or error
        raise ValueError(f"`file`: {file}: {why} (an absolute path, or one from {Path.cwd()})") from error
    try:
        database = cantools.database.load_string(text, "dbc", strict=False)
    except cantools.Error as error:
        raise ValueError(f"`file`: {file}: not a DBC file: {error}") from error
    return database.messages if isinstance(database, cantools.database.can.Database) else []


def _signal(messages: Mapping[str, "Message"], name: str) -> Signal:
    """The table of one signal. Raises ValueError if there is none, or none that can be."""
    message_name, _, signal_name = name.partition(".")
    message = _known(messages, message_name, "message")
    signal = _known(
        {signal.name: signal for signal in message.signals}, signal_name, f"{message_name} signal"
    )
    if signal.multiplexer_ids is not None:
        raise ValueError(f"{name} is multiplexed: that is not supported")
    little = signal.byte_order == "little_endian"
    from_top = signal.start // 8 * 8 + 7 - signal.start % 8
    shift = signal.start if little else 8 * message.length - from_top - signal.length
    if message.length > LONGEST or shift < 0 or shift + signal.length > 8 * message.length:
        raise ValueError(f"{name} does not fit a frame of {min(message.length, LONGEST)} bytes")
    if signal.is_float and signal.length not in FLOATS:
        raise ValueError(f"{name} is a float of {signal.length} bits: expected 16, 32 or 64")
    return Signal(
        message.frame_id,
        message.is_extended_frame,
        message.length,
        "little" if little else "big",
        shift,
        signal.length,
        signal.is_signed,
        signal.is_float,
        float(signal.scale),
        float(signal.offset),
    )


def _known(table: Mapping[str, T], name: str, kind: str) -> T:
    """The entry of that name. Raises ValueError, with a hint."""
    if name not in table:
        near = get_close_matches(name, table, n=1)
        hint = f"did you mean {near[0]!r}?" if near else f"there are: {', '.join(sorted(table)[:MOST_NAMED])}"
        raise ValueError(f"no {kind} {name!r} in the DBC file ({hint})")
    return table[name]
