"""An emulated moteus: a wheel's motor controller that answers requests for its registers, by CAN-FD."""

import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import isfinite, nan, tau
from random import Random
from typing import ClassVar

from echogrid.drivers.bus import FD_LENGTHS, NEVER_NS, CanFrame
from echogrid.emulation.devices.can_node import CanNode
from echogrid.emulation.devices.device import LOOKED_UP
from echogrid.emulation.faults import Verb

_STARTUP_NS = 300_000_000
"""From power-up until it answers: a guess."""
_ANSWER_NS = 100_000
"""From a request to its reply: a guess."""
_SLOPE_NS = 5_000_000
"""The velocity is the mean over so long."""
_VOLTS, _COOL, _HOT = 24.0, 35.0, 72.0
_STOPPED, _FAULT = 0, 1
_DRIVER_FAULT, _ENCODER_FAULT = 33, 35
_ONE_SOURCE = 0b11
"""Angle and velocity of the first."""
_UNKNOWN_REGISTER = 1
_MOST = 64
_ENDS = ("<b", "<h", "<i", "<f")
_BITS = (8, 16, 32)
_FLOAT = 3
_FLOAT_MILLISECONDS = 8_388_608
"""Where its counter of milliseconds begins anew if it is read as a float."""


@dataclass(frozen=True, slots=True)
class MoteusOptions:
    """How the controller is configured."""

    node: int = 1
    prefix: int = 0
    """The identifier's bits above the sixteen."""
    gear: float = 1.0
    """Turns of its output for one of the wheel; negative if it counts backwards."""
    origin: float = 0.0
    """Turns that it has made already."""
    counts_milliseconds: int = 1
    """0: it has older firmware, without that register."""

    def __post_init__(self) -> None:
        if not 1 <= self.node <= 127:
            raise ValueError(f"node {self.node} is no id of a moteus (1 to 127)")
        if not 0 <= self.prefix <= 0x1FFF:
            raise ValueError(f"prefix {self.prefix:#x} does not fit thirteen bits")


class Moteus(CanNode):
    """Sends nothing unless it is asked. What it is told to do is passed over: its motor is not emulated.

    The position begins within half a turn of where the encoder has its zero.
    """

    fd: ClassVar[bool] = True

    def __init__(
        self,
        name: str,
        angle: Callable[[int], float],
        random: Random,
        options: MoteusOptions = MoteusOptions(),
    ) -> None:
        super().__init__(name)
        self._angle = angle
        self._random = random
        self._options = options
        self._start_ns = NEVER_NS
        self._booted_ns: int | None = None
        self._zero = 0.0

    def receive(self, frame: CanFrame, now_ns: int) -> None:
        """Answer a request to it, if one is wanted; while it starts up it hears none."""
        identifier = frame.identifier
        addressed = identifier >> 16 == self._options.prefix and identifier & 0xFF == self._options.node
        if not (frame.fd and addressed and identifier & 0x8000) or self._booted_ns is None:
            return
        payload = self._answer(frame.data, now_ns)
        if "garbage" in self.faults:
            payload = self._random.randbytes(len(payload))
        source = identifier >> 8 & 0x7F
        answer = self._options.prefix << 16 | self._options.node << 8 | source
        due_ns = now_ns + _ANSWER_NS + self._delay_ns()
        self.post(CanFrame(answer, payload, extended=answer > 0x7FF, fd=True), due_ns)

    def _verbs(self) -> Mapping[str, Verb]:
        own = dict.fromkeys(("encoder_lost", "motor_failed", "overheated"), LOOKED_UP)
        return {**super()._verbs(), **own}

    def _power_up(self, now_ns: int) -> None:
        self._start_ns = now_ns + _STARTUP_NS

    def _power_down(self) -> None:
        self._start_ns = NEVER_NS
        self._booted_ns = None
        self.withdraw()

    def _next_ns(self) -> int:
        return self._start_ns

    def _step(self, now_ns: int) -> None:
        if now_ns >= self._start_ns:
            self._start_ns = NEVER_NS
            self._booted_ns = now_ns
            self._zero = round(self._turns(now_ns))

    def _turns(self, now_ns: int) -> float:
        return self._angle(now_ns) / tau * self._options.gear

    def _answer(self, request: bytes, now_ns: int) -> bytes:
        """The subframes that answer those of a request, as far as a frame holds them."""
        told = b""
        for form, first, count in reads(request):
            answer = self._registers(form, first, count, now_ns)
            if len(told) + len(answer) > _MOST:
                break
            told += answer
        return told.ljust(next(length for length in FD_LENGTHS if length >= len(told)), b"\x50")

    def _registers(self, form: int, first: int, count: int, now_ns: int) -> bytes:
        """A reply with registers in a row; an error for the first of them that there is not."""
        values = b""
        for register in range(first, first + min(count, _MOST)):
            value = self._register(register, form, now_ns)
            if value is None:
                return b"\x31" + varuint(register) + varuint(_UNKNOWN_REGISTER)
            values += value
        head = (
            bytes((0x20 | form << 2 | count,)) if count <= 3 else bytes((0x20 | form << 2,)) + varuint(count)
        )
        return head + varuint(first) + values

    def _register(self, register: int, form: int, now_ns: int) -> bytes | None:
        lost, failed = "encoder_lost" in self.faults, "motor_failed" in self.faults
        match register:
            case 0x000:
                return whole(_FAULT if lost or failed else _STOPPED, form)
            case 0x001:
                position = nan if lost else self._turns(now_ns) - self._zero + self._options.origin
                return scaled(position, form, (0.01, 0.0001, 0.00001))
            case 0x002:
                turned = self._turns(now_ns) - self._turns(now_ns - _SLOPE_NS)
                return scaled(nan if lost else turned / _SLOPE_NS * 1e9, form, (0.1, 0.00025, 0.00001))
            case 0x003:
                return scaled(0.0, form, (0.5, 0.01, 0.001))
            case 0x00D:
                return scaled(_VOLTS, form, (0.5, 0.1, 0.001))
            case 0x00E:
                return scaled(_HOT if "overheated" in self.faults else _COOL, form, (1.0, 0.1, 0.001))
            case 0x00F:
                return whole(_ENCODER_FAULT if lost else _DRIVER_FAULT if failed else 0, form)
            case 0x058:
                return whole(0 if lost else _ONE_SOURCE, form)
            case 0x070 if self._options.counts_milliseconds:
                return milliseconds((now_ns - (self._booted_ns or 0)) // 1_000_000, form)
        return None


def whole(number: int, form: int) -> bytes:
    """A small whole number: as an int of 8, 16 or 32 bits (form 0 to 2), or as a float (3)."""
    return struct.pack(_ENDS[form], number)


def scaled(value: float, form: int, steps: tuple[float, float, float]) -> bytes:
    """A value in steps, which ends at what the form holds; the lowest of all says that there is none."""
    if form == _FLOAT:
        return struct.pack("<f", value)
    most = (1 << _BITS[form] - 1) - 1
    if not isfinite(value):
        return struct.pack(_ENDS[form], -most - 1)
    # The firmware has its values in single precision.
    (single,) = struct.unpack("<f", struct.pack("<f", value))
    return struct.pack(_ENDS[form], max(-most, min(most, int(single / steps[form]))))


def milliseconds(count: int, form: int) -> bytes:
    """A counter that goes on from the highest number of the form to its lowest."""
    if form == _FLOAT:
        return struct.pack("<f", count % _FLOAT_MILLISECONDS)
    half = 1 << _BITS[form] - 1
    return struct.pack(_ENDS[form], (count + half) % (2 * half) - half)


def varuint(number: int) -> bytes:
    """Seven bits to a byte, the lowest first; all bytes but the last have their highest bit."""
    if number < 0x80:
        return bytes((number,))
    return bytes((number & 0x7F | 0x80,)) + varuint(number >> 7)


def reads(request: bytes) -> list[tuple[int, int, int]]:
    """Form, first register and count of each subframe that reads; it ends where it can't be understood."""
    found: list[tuple[int, int, int]] = []
    rest = request
    while rest:
        kind, rest = rest[0], rest[1:]
        if kind == 0x50:
            continue
        if kind >= 0x20:
            break
        form, count = kind >> 2 & 3, kind & 3
        if not count:
            count, rest = _number(rest)
        if not count:
            continue
        first, rest = _number(rest)
        if kind < 0x10:
            rest = rest[count * struct.calcsize(_ENDS[form]) :]
        else:
            found.append((form, first, count))
    return found


def _number(data: bytes) -> tuple[int, bytes]:
    """A varuint at the front, and what is behind it."""
    number = 0
    for at, byte in enumerate(data[:5]):
        number |= (byte & 0x7F) << 7 * at
        if byte < 0x80:
            return number, data[at + 1 :]
    return number, b""
