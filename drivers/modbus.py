"""Modbus RTU without input or output: requests, and what the replies to them say.

Frames, checksums and messages are pymodbus's. That a reply is one frame and no more, and answers its request,
is looked at here: left to itself pymodbus passes over what stands before a frame, and what stands behind it.
"""

from dataclasses import dataclass

from pymodbus.constants import ExcCodes
from pymodbus.framer import FramerRTU
from pymodbus.pdu import DecodePDU
from pymodbus.pdu.register_message import ReadHoldingRegistersRequest, WriteSingleRegisterRequest

ILLEGAL_ADDRESS, BUSY = int(ExcCodes.ILLEGAL_ADDRESS), int(ExcCodes.DEVICE_BUSY)
"""Exceptions: there is no such register; the device can't answer now."""
_EXCEPTIONS = {int(code): code.name.lower().replace("_", " ") for code in ExcCodes}
_REFUSED = 0x80
"""Set in the function code of an exception."""
_EXCEPTION_LENGTH = 5
_HEAD_AND_TAIL = 3
"""Bytes of a frame that are not its message: the address, and two of checksum."""

_PDUS = DecodePDU(is_server=False)
_FRAMER = FramerRTU(_PDUS)


def quiet_ns(baud: int, bits_per_byte: int = 11) -> int:
    """The silence that ends a frame: 3.5 characters, and 1.75 ms above 19 200 baud
    (MODBUS over Serial Line V1.02, 2.5.1.1)."""
    return 1_750_000 if baud > 19_200 else 3_500_000_000 * bits_per_byte // baud


@dataclass(frozen=True, slots=True)
class Reply:
    """What a device answered."""

    registers: tuple[int, ...] = ()
    """Those that were read, or the one that was written."""
    exception: int | None = None
    """The code with which it refused, if it did."""
    doubt: str = ""
    """Why this cannot be a reply to the request; empty if it can."""

    @property
    def refusal(self) -> str:
        """The exception in words; empty if there is none."""
        if self.exception is None:
            return ""
        return f"{_EXCEPTIONS.get(self.exception, 'unknown')} (Modbus exception {self.exception})"


@dataclass(frozen=True, slots=True)
class Request:
    """A request to one device."""

    frame: bytes
    head: bytes
    """With what the reply begins, if it is no exception."""
    length: int
    """Its bytes then."""

    def reply_length(self, heard: bytes) -> int:
        """How long the reply will be, by what has come of it; 0: that cannot be told yet."""
        if len(heard) < 2:
            return 0
        return _EXCEPTION_LENGTH if heard[1] & _REFUSED else self.length

    def reply(self, heard: bytes) -> Reply:
        """What the bytes say that came as the reply. Never raises."""
        if not heard or len(heard) != self.reply_length(heard):
            return Reply(doubt=f"a reply of the wrong length ({heard.hex(' ') or 'nothing'})")
        refused = bytes((self.frame[0], self.frame[1] | _REFUSED))
        if not heard.startswith((self.head, refused)):
            return Reply(doubt=f"a reply to something else ({heard.hex(' ')})")
        _, _, _, message = _FRAMER.decode(heard)
        said = _PDUS.decode(message) if len(message) + _HEAD_AND_TAIL == len(heard) else None
        if said is None:
            return Reply(doubt=f"a reply with a wrong checksum ({heard.hex(' ')})")
        return Reply(exception=said.exception_code) if said.isError() else Reply(tuple(said.registers))


def read(device: int, register: int, count: int) -> Request:
    """Ask for `count` holding registers from that one on (function 03)."""
    message = ReadHoldingRegistersRequest(dev_id=device, address=register, count=count)
    frame = _FRAMER.buildFrame(message)
    return Request(frame, frame[:2] + bytes((2 * count,)), 5 + 2 * count)


def write(device: int, register: int, value: int) -> Request:
    """Set one register (function 06): the reply repeats the request."""
    message = WriteSingleRegisterRequest(dev_id=device, address=register, registers=[value])
    frame = _FRAMER.buildFrame(message)
    return Request(frame, frame, len(frame))
