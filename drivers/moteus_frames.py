"""The register protocol of moteus controllers: frames of CAN-FD that are made of subframes.

Sources: mjbots/moteus, docs/protocol/can.md and registers.md; mjbots/mjlib, mjlib/multiplex/format.h.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from math import nan
from struct import Struct

from echogrid.drivers.bus import FD_LENGTHS

REPLY_WANTED = 0x8000
"""A bit of the identifier. Above it are those of the prefix, below seven of the source and eight of the
destination."""
NODES = 0x7F

FAULTS = {
    32: "calibration fault",
    33: "motor driver fault",
    34: "over voltage",
    35: "encoder fault",
    36: "motor not configured",
    37: "PWM cycle overrun",
    38: "over temperature",
    39: "outside limit",
    40: "under voltage",
    41: "configuration changed",
    42: "theta invalid",
    43: "position invalid",
    44: "driver enable fault",
    45: "stop position deprecated",
    46: "timing violation",
    47: "feedforward without acceleration",
    48: "invalid limits",
}
"""By the register FAULT, in the mode of a fault."""


class Register(IntEnum):
    """What is asked for."""

    MODE = 0x000
    POSITION = 0x001
    VELOCITY = 0x002
    VOLTAGE = 0x00D
    TEMPERATURE = 0x00E
    FAULT = 0x00F
    ENCODER_VALIDITY = 0x058
    MILLISECOND_COUNTER = 0x070


class Form(IntEnum):
    """In which a register's value is sent: the two bits above the two lowest of a subframe's kind."""

    INT8 = 0
    INT16 = 1
    INT32 = 2
    FLOAT = 3


_FORMS = (Struct("<b"), Struct("<h"), Struct("<i"), Struct("<f"))
_NO_NUMBER = {Form.INT8: -(1 << 7), Form.INT16: -(1 << 15), Form.INT32: -(1 << 31)}
_STEPS: Mapping[Register, tuple[float, float, float, float]] = {
    Register.POSITION: (0.01, 0.0001, 0.00001, 1.0),
    Register.VELOCITY: (0.1, 0.00025, 0.00001, 1.0),
    Register.VOLTAGE: (0.5, 0.1, 0.001, 1.0),
    Register.TEMPERATURE: (1.0, 0.1, 0.001, 1.0),
}
"""By form; turns, turns/s, V and C."""

_WRITE, _READ, _REPLY = 0x00, 0x10, 0x20
_WRITE_ERROR, _READ_ERROR = 0x30, 0x31
_TO_CLIENT, _TO_SERVER, _FLOW_TO_CLIENT = 0x41, 0x40, 0x43
_POLL, _FLOW_POLL = 0x42, 0x44
_PADDING = 0x50
_LONGEST_VARUINT = 5


@dataclass(frozen=True, slots=True)
class Value:
    """A register's value as it was sent."""

    form: Form
    raw: int | float


@dataclass(frozen=True, slots=True)
class Replies:
    """What a frame tells."""

    values: Mapping[int, Value]
    """By register."""
    errors: Mapping[int, int]
    """Why a register can't be read, by register."""
    whole: bool
    """Whether it is understood to its end; if not, only what came before is here."""

    def quantity(self, register: Register) -> float:
        """Turns, turns/s, V or C; NaN if it is not told, or has no value."""
        value = self.values.get(register)
        if value is None or value.raw == _NO_NUMBER.get(value.form):
            return nan
        return value.raw * _STEPS[register][value.form]

    def number(self, register: Register) -> int | None:
        """A whole number; None if it is not told in whole numbers."""
        value = self.values.get(register)
        return None if value is None or value.form is Form.FLOAT else int(value.raw)


def read(form: Form, first: int, count: int = 1) -> bytes:
    """The subframe that asks for some registers in a row, at most three."""
    return bytes((_READ | form << 2 | count,)) + _varuint(first)


def padded(subframes: Sequence[bytes]) -> bytes:
    """The frame that they make, of a length that CAN-FD has."""
    data = b"".join(subframes)
    length = next(each for each in FD_LENGTHS if each >= len(data))
    return data.ljust(length, bytes((_PADDING,)))


def parse(data: bytes) -> Replies:
    """What a frame tells. Subframes that tell nothing are passed over; nothing is ever raised."""
    reader, values, errors = _Reader(data), dict[int, Value](), dict[int, int]()
    try:
        while reader.left:
            _subframe(reader, values, errors)
    except ValueError:
        return Replies(values, errors, whole=False)
    return Replies(values, errors, whole=True)


def _subframe(reader: "_Reader", values: dict[int, Value], errors: dict[int, int]) -> None:
    """Take the next one. Raises ValueError if there is no such kind, or if it is cut short."""
    kind = reader.byte()
    if kind < _WRITE_ERROR:
        _registers(kind, reader, values)
    elif kind in (_WRITE_ERROR, _READ_ERROR):
        register, error = reader.varuint(), reader.varuint()
        if kind == _READ_ERROR:
            errors[register] = error
    elif kind in (_TO_SERVER, _TO_CLIENT, _FLOW_TO_CLIENT):
        reader.varuint()
        if kind == _FLOW_TO_CLIENT:
            reader.byte()
        reader.take(reader.varuint())
    elif kind in (_POLL, _FLOW_POLL):
        reader.varuint()
        if kind == _FLOW_POLL:
            reader.byte()
        reader.varuint()
    elif kind != _PADDING:
        raise ValueError(f"no subframe begins with {kind:#x}")


def _registers(kind: int, reader: "_Reader", values: dict[int, Value]) -> None:
    form, what = Form(kind >> 2 & 3), kind & 0xF0
    count = kind & 3 or reader.varuint()
    if not count:
        return  # then there is no register, either: so the maker's own parser takes it
    first = reader.varuint()
    if what == _READ:
        return
    struct = _FORMS[form]
    packed = reader.take(count * struct.size)
    if what == _REPLY:
        values |= {first + at: Value(form, raw) for at, (raw,) in enumerate(struct.iter_unpack(packed))}


def _varuint(number: int) -> bytes:
    """Seven bits in each byte, the lowest first."""
    packed = bytearray()
    while number > 0x7F:
        packed.append(0x80 | number & 0x7F)
        number >>= 7
    packed.append(number)
    return bytes(packed)


class _Reader:
    """A frame from its front to its end. All raise ValueError when there is not so much left."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._at = 0

    @property
    def left(self) -> int:
        """So many bytes."""
        return len(self._data) - self._at

    def take(self, count: int) -> bytes:
        """So many bytes."""
        if count > self.left:
            raise ValueError(f"{count} bytes of {self.left}")
        self._at += count
        return self._data[self._at - count : self._at]

    def byte(self) -> int:
        """The next one."""
        return self.take(1)[0]

    def varuint(self) -> int:
        """A number of at most five bytes."""
        number = 0
        for at in range(_LONGEST_VARUINT):
            byte = self.byte()
            number |= (byte & 0x7F) << 7 * at
            if byte < 0x80:
                return number
        raise ValueError("a varuint has at most five bytes")
