"""A CAN bus behind an adapter of the Lawicel kind: frames as lines of text on a pseudo-terminal."""

import re
from collections.abc import Sequence
from pathlib import Path

from echogrid.drivers.bus import CanFrame
from echogrid.drivers.clock import Clock
from echogrid.emulation.buses.can_bus import CanBus
from echogrid.emulation.errors import RobotSpecError
from echogrid.emulation.wires.loop import Loop
from echogrid.emulation.wires.pty import TerminalWire

BIT_RATES = (10_000, 20_000, 50_000, 100_000, 125_000, 250_000, 500_000, 800_000, 1_000_000)
"""By the digit after `S`."""

_DONE, _ERROR = b"\r", b"\a"
_LONGEST_LINE = len("T0000000080011223344556677")
_DATA = re.compile(r"(?:t([0-7][0-9A-F]{2})|T([01][0-9A-F]{7}))([0-8])((?:[0-9A-F]{2})*)", re.IGNORECASE)
_REMOTE = re.compile(r"(?:r([0-7][0-9A-F]{2})|R([01][0-9A-F]{7}))([0-8])", re.IGNORECASE)


class SlcanAdapter:
    """The adapter's state: the channel, which is open or not, and the line that is half read.

    Opened at another bit rate than the bus has, it neither hears nor is heard.
    """

    def __init__(self, bit_rate: int) -> None:
        self._bus_rate = bit_rate
        self._chosen_rate: int | None = None
        self._open = False
        self._line = bytearray()

    def receive(self, data: bytes) -> tuple[list[CanFrame], bytes]:
        """The frames that the client sends, and the answer to it."""
        frames: list[CanFrame] = []
        answers = bytearray()
        for byte in data:
            if byte != _DONE[0]:
                self._line.append(byte)
                continue
            line = self._line.decode("latin-1")
            self._line.clear()
            answers += self._obey(line, frames)
        del self._line[_LONGEST_LINE + 1 :]
        return frames, bytes(answers)

    def line(self, frame: CanFrame) -> bytes:
        """The line for a frame from the bus; b"" while the channel does not hear."""
        return encode(frame) if self._hears() else b""

    def _obey(self, line: str, frames: list[CanFrame]) -> bytes:
        if line in ("", "C"):
            self._open = self._open and line != "C"
            return _DONE
        if line == "O" and self._chosen_rate is not None:
            self._open = True
            return _DONE
        if line == "V":
            return b"V1013" + _DONE
        if re.fullmatch("S[0-8]", line) and not self._open:
            self._chosen_rate = BIT_RATES[int(line[1])]
            return _DONE
        frame = decode(line) if self._open else None
        if frame is None:
            return _ERROR
        if self._hears():
            frames.append(frame)
        return _DONE

    def _hears(self) -> bool:
        return self._open and self._chosen_rate == self._bus_rate


class SlcanWire(TerminalWire[CanFrame, CanFrame]):
    """A CAN bus as a pseudo-terminal that speaks slcan. Its speed is that of USB: any will do."""

    def __init__(self, bus: CanBus, link: Path, clock: Clock, loop: Loop) -> None:
        """Raises RobotSpecError if a node of the bus speaks CAN-FD: slcan has no such frames."""
        if bus.fd:
            raise RobotSpecError(
                f"{bus.name}: slcan, on which an emulated CAN bus is served, has no CAN-FD: leave the "
                "controllers that speak it (moteus) out"
            )
        super().__init__(bus, link, clock, loop, None)
        self._bit_rate = bus.bit_rate

    def _attach(self) -> None:
        self._adapter = SlcanAdapter(self._bit_rate)
        super()._attach()

    def _receive(self) -> None:
        frames, answer = self._adapter.receive(self._terminal.read())
        self._terminal.write(answer)
        self._send(frames)

    def _deliver(self, items: Sequence[CanFrame]) -> None:
        lines = b"".join(self._adapter.line(frame) for frame in items)
        if lines:
            self._terminal.write(lines)


def encode(frame: CanFrame) -> bytes:
    """A frame's line."""
    kind = "r" if frame.remote else "t"
    identifier = f"{frame.identifier:08X}" if frame.extended else f"{frame.identifier:03X}"
    head = f"{kind.upper() if frame.extended else kind}{identifier}{len(frame.data)}"
    return f"{head}{frame.data.hex().upper()}\r".encode("ascii")


def decode(line: str) -> CanFrame | None:
    """A line's frame; None if it is none. A request's length is not kept: CanFrame has no place for it."""
    if request := _REMOTE.fullmatch(line):
        standard, extended, _ = request.groups()
        return CanFrame(int(standard or extended, 16), b"", extended=standard is None, remote=True)
    frame = _DATA.fullmatch(line)
    if frame is None:
        return None
    standard, extended, length, data = frame.groups()
    if len(data) != 2 * int(length):
        return None
    return CanFrame(int(standard or extended, 16), bytes.fromhex(data), extended=standard is None)
