"""What every emulated Modbus RTU slave has, from the Modbus standard: frames between silences, a checksum,
functions 03 (read holding registers) and 06 (write one register), and refusals."""

import struct
from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from random import Random

from echogrid.drivers.bus import NEVER_NS
from echogrid.emulation.devices.device import LOOKED_UP
from echogrid.emulation.devices.serial_device import SerialDevice
from echogrid.emulation.faults import Verb

READ, WRITE = 3, 6
_REFUSED = 0x80
_ILLEGAL_FUNCTION, ILLEGAL_ADDRESS, ILLEGAL_VALUE, _BUSY = 1, 2, 3, 6
_BROADCAST = 0
_MOST_REGISTERS = 125
PARITIES = ("none", "even", "odd")
"""In the order of their codes."""
_LEAST_FRAME = 4
_STORM = 0.7
"""Of the requests in a storm so many are refused."""
_SECOND_NS = 1_000_000_000


def crc16(data: bytes) -> int:
    """The checksum over a frame: polynomial 0xA001 from the low end, from ones (V1.02, 6.2.2)."""
    crc = 0xFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0xA001 if crc & 1 else 0)
    return crc


def sealed(body: bytes) -> bytes:
    """A frame of its address and message: the checksum behind them, low byte first."""
    return body + crc16(body).to_bytes(2, "little")


@dataclass(frozen=True, slots=True)
class SlaveOptions:
    """How a slave is set on its line."""

    address: int = 1
    baud: int = 9600
    parity: str = "none"
    """Or "even", or "odd"."""
    stop_bits: int = 1
    echo: int = 0
    """1: the host's adapter hands back what it sends."""
    turnaround_ns: int = 1_000_000
    """From a request's closing silence to the reply: unknown, a guess."""

    def __post_init__(self) -> None:
        if not 1 <= self.address <= 247:
            raise ValueError(f"address {self.address} is not one of a slave (1 to 247)")
        if self.parity not in PARITIES:
            raise ValueError(f"parity {self.parity!r} is none of {', '.join(PARITIES)}")


class ModbusSlave(SerialDevice):
    """Takes for a frame what stands between silences of 3.5 characters, by a timer that every byte restarts.

    A request that comes too close behind somebody's reply is one frame with it, and lost.
    """

    shares_line = True

    def __init__(self, name: str, options: SlaveOptions, random: Random) -> None:
        super().__init__(name, options.baud, 9 + (options.parity != "none") + options.stop_bits)
        self.one_wire = bool(options.echo)
        self.address = options.address
        self._random = random
        self._turnaround_ns = options.turnaround_ns
        self._character_ns = self.bits_per_byte * _SECOND_NS // options.baud
        self._silence_ns = 1_750_000 if options.baud > 19_200 else 7 * self._character_ns // 2
        self._frame = bytearray()
        self._closes_ns = NEVER_NS
        self._quiet_ns = 0

    def receive(self, data: bytes, now_ns: int) -> None:
        """Take a part of a request."""
        glued = now_ns - len(data) * self._character_ns < self._quiet_ns
        if glued and not self._frame:
            self.overhear(data, now_ns)
            return
        self._frame += data
        self._closes_ns = now_ns + self._silence_ns
        self._quiet_ns = self._closes_ns

    def overhear(self, data: bytes, now_ns: int) -> None:
        """Take a part of somebody's reply: it breaks the silence, whatever it says."""
        del data
        self._frame.clear()
        self._closes_ns = NEVER_NS
        self._quiet_ns = now_ns + self._silence_ns

    def _verbs(self) -> Mapping[str, Verb]:
        return {**super()._verbs(), "nack_storm": LOOKED_UP}

    def _power_up(self, now_ns: int) -> None:
        """Listen."""

    def _power_down(self) -> None:
        self._frame.clear()
        self._closes_ns = NEVER_NS
        self.output.stop()

    def _next_ns(self) -> int:
        return self._closes_ns

    def _step(self, now_ns: int) -> None:
        if now_ns >= self._closes_ns:
            frame = bytes(self._frame)
            self._frame.clear()
            self._closes_ns = NEVER_NS
            if len(frame) >= _LEAST_FRAME and sealed(frame[:-2]) == frame:
                self._take(frame[0], frame[1:-2], now_ns)

    def _take(self, address: int, message: bytes, now_ns: int) -> None:
        """Obey a message to this slave, or to all: those are not answered."""
        if address == _BROADCAST:
            self._obey(message, now_ns)
        elif address == self.address:
            stormed = "nack_storm" in self.faults and self._random.random() < _STORM
            reply = _refusal(message[0], _BUSY) if stormed else self._obey(message, now_ns)
            if reply:
                self._reply(reply, now_ns + self._turnaround_ns)

    def _obey(self, message: bytes, now_ns: int) -> bytes:
        """Do what it says; the reply to it, or nothing if that comes later."""
        function, *_ = message
        if function not in (READ, WRITE):
            return _refusal(function, _ILLEGAL_FUNCTION)
        if len(message) != 5:
            return _refusal(function, ILLEGAL_VALUE)
        register, word = struct.unpack(">HH", message[1:])
        if function == WRITE:
            code = self._write(register, word, now_ns)
            return _refusal(WRITE, code) if code else message
        if not 1 <= word <= _MOST_REGISTERS:
            return _refusal(READ, ILLEGAL_VALUE)
        return self._read(range(register, register + word), now_ns)

    def _read(self, registers: range, now_ns: int) -> bytes:
        """The reply to a reading of registers, or nothing if it comes later."""
        del now_ns
        words = [self._word(register) for register in registers]
        told = b"".join(word.to_bytes(2, "big") for word in words if word is not None)
        if None in words:
            return _refusal(READ, ILLEGAL_ADDRESS)
        return bytes((READ, len(told))) + told

    def _reply(self, message: bytes, start_ns: int) -> None:
        """Send a message in its frame from that time on."""
        frame = sealed(bytes((self.address,)) + message)
        if "garbage" in self.faults:
            frame = self._random.randbytes(len(frame))
        self.send(frame, start_ns + self._delay_ns())

    @abstractmethod
    def _word(self, register: int) -> int | None:
        """What a register holds; None if there is no such register."""

    @abstractmethod
    def _write(self, register: int, word: int, now_ns: int) -> int:
        """Set a register; 0, or the code with which that is refused."""


def _refusal(function: int, code: int) -> bytes:
    return bytes((function | _REFUSED, code))
