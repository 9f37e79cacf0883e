"""CAN over a serial line as lines of text (slcan, Lawicel), by any adapter that speaks it.

Source: Lawicel AB, CANUSB manual 1.0C, chapter 3; its time stamps (`Z1`) must be off, as they are unless set.
"""

import time
from binascii import unhexlify
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress

from echogrid.drivers.bus import CanFrame
from echogrid.drivers.errors import PortError
from echogrid.drivers.transports.mend import cannot_open
from echogrid.drivers.transports.serial import SerialPort

BIT_RATES: Mapping[int, bytes] = {
    10_000: b"S0",
    20_000: b"S1",
    50_000: b"S2",
    100_000: b"S3",
    125_000: b"S4",
    250_000: b"S5",
    500_000: b"S6",
    800_000: b"S7",
    1_000_000: b"S8",
}
TTY_BAUD = 115_200
"""Of adapters with a UART; those on USB take any."""
CLOSE, OPEN = b"C\r", b"O\r"

DONE, REFUSED = b"\r", b"\a"
LONGEST_LINE = len("T1FFFFFFF80011223344556677")
SENT = (b"z", b"Z")
ANSWERS = b"VNF"
"""What answers to version, serial number and status begin with: another program may have asked."""
STANDARD, EXTENDED = 2, 5
"""Bytes of an identifier and the length behind it: 3 + 1 hexadecimal digits, or 8 + 1 and a zero before."""
HIGHEST = {STANDARD: 0x7FF, EXTENDED: 0x1FFF_FFFF}


class LineReader:
    """Makes frames of what an adapter says, in chunks of any size; what is no line of slcan is counted."""

    def __init__(self, counts: Counter[str]) -> None:
        self._counts = counts
        self._rest = b""

    def frames(self, chunk: bytes, stamp_ns: int) -> list[CanFrame]:
        """Those that the chunk completes."""
        # A refusal has no end of line of its own.
        *lines, rest = (self._rest + chunk.replace(REFUSED, REFUSED + DONE)).split(DONE)
        self._rest = rest[: LONGEST_LINE + 1]
        frames: list[CanFrame] = []
        for line in lines:
            if frame := frame_of(line, stamp_ns):
                frames.append(frame)
            elif line == REFUSED:
                self._counts["refused lines"] += 1
            elif line and line not in SENT and line[0] not in ANSWERS:
                self._counts["malformed lines"] += 1
        return frames


def frame_of(line: bytes, stamp_ns: int = 0) -> CanFrame | None:
    """The frame that a line, without its end, says; None if it says none."""
    kind = line[:1]
    extended, remote = kind in (b"T", b"R"), kind in (b"r", b"R")
    if not (extended or remote or kind == b"t"):
        return None
    try:
        packed = unhexlify(b"0" + line[1:] if extended else line[1:])
    except ValueError:
        return None
    size = EXTENDED if extended else STANDARD
    head = int.from_bytes(packed[:size], "big")
    identifier, length = head >> 4, head & 0xF
    if length > 8 or identifier > HIGHEST[size] or len(packed) != size + (0 if remote else length):
        return None
    return CanFrame(identifier, packed[size:], extended, remote, stamp_ns)


def line_of(frame: CanFrame) -> bytes:
    """What tells an adapter to send the frame, with its end."""
    kind = ("R" if frame.extended else "r") if frame.remote else ("T" if frame.extended else "t")
    digits = 8 if frame.extended else 3
    line = f"{kind}{frame.identifier:0{digits}X}{len(frame.data)}{frame.data.hex().upper()}\r"
    return line.encode("ascii")


def opening(bitrate: int) -> bytes:
    """What makes an adapter ready, from whatever it was at: the lines of python-can, so adapters know them.

    Raises ValueError if it knows no such bit rate.
    """
    if bitrate not in BIT_RATES:
        raise ValueError(f"bitrate is {bitrate}: slcan has {', '.join(map(str, BIT_RATES))}")
    return CLOSE + BIT_RATES[bitrate] + b"\r\r" + OPEN + OPEN


class SlcanChannel:
    """An adapter on a serial port. A frame's stamp is the time when it was read."""

    def __init__(self, address: str, bitrate: int, tty_baudrate: int, counts: Counter[str]) -> None:
        self._address = address
        self._bitrate = bitrate
        self._counts = counts
        self._port = SerialPort(address, baud=tty_baudrate, kind="CAN")
        self._reader = LineReader(counts)

    def open(self) -> None:
        """Make ready. Raises PortError, which names the port and the mend."""
        try:
            lines = opening(self._bitrate)
        except ValueError as error:
            raise cannot_open("CAN", self._address, "dialout", error) from error
        self._port.open()
        self._reader = LineReader(self._counts)
        self._port.write((lines,))

    def close(self) -> None:
        """Let go. May be called twice."""
        with suppress(PortError):  # an unplugged adapter cannot be told, nor one that is closed already
            self._port.write((CLOSE,))
        self._port.close()

    def send(self, frames: Sequence[CanFrame]) -> int:
        """Send; how many were: all of them. Raises PortError when the port is lost."""
        self._port.write((b"".join(map(line_of, frames)),))
        return len(frames)

    def receive(self, wait_s: float) -> list[CanFrame]:
        """What has come in. Raises PortError when the port is lost."""
        chunks = self._port.read(wait_s)
        stamp_ns = time.monotonic_ns()
        return [frame for chunk in chunks for frame in self._reader.frames(chunk, stamp_ns)]
