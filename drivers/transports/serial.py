"""Serial ports, by pyserial."""

import select
import termios
import time
from collections.abc import Sequence
from contextlib import suppress
from typing import TYPE_CHECKING

from echogrid.drivers.bus import Break
from echogrid.drivers.errors import PortError
from echogrid.drivers.limits import require_between
from echogrid.drivers.transports.mend import cannot_open

if TYPE_CHECKING:
    import serial

MOST_BYTES = 4096
"""One read takes no more, so that a babbling line cannot hold its thread."""
WRITE_WITHIN_S = 0.1
PARITIES = {"none": "N", "even": "E", "odd": "O"}


class SerialPort:
    """A serial port, held exclusively: eight data bits, with or without parity, one or two stop bits."""

    def __init__(
        self,
        address: str,
        *,
        baud: int = 9600,
        stop_bits: int = 1,
        parity: str = "none",
        kind: str = "serial",
    ) -> None:
        """`kind` is what hangs on it, for messages."""
        require_between("baud", baud, 50, 4_000_000)
        require_between("stop_bits", stop_bits, 1, 2)
        if parity not in PARITIES:
            raise ValueError(f"parity is {parity!r}: expected one of {', '.join(PARITIES)}")
        self._address = address
        self._kind = kind
        self._baud = baud
        self._stop_bits = stop_bits
        self._parity = PARITIES[parity]
        self._serial: serial.Serial | None = None

    def open(self) -> None:
        """Make ready. Raises PortError, which names the port and the mend."""
        import serial

        self.close()
        try:
            self._serial = serial.Serial(
                self._address,
                self._baud,
                parity=self._parity,
                stopbits=self._stop_bits,
                timeout=0,
                write_timeout=WRITE_WITHIN_S,
                exclusive=True,
            )
        except (OSError, ValueError, termios.error) as error:
            raise cannot_open(self._kind, self._address, "dialout", error) from error
        _hand_over_at_once(self._serial)

    def close(self) -> None:
        """Let go. May be called twice."""
        if self._serial is not None:
            self._serial.close()
            self._serial = None

    def write(self, items: Sequence[bytes | Break]) -> None:
        """Send; a break takes its time. Raises PortError when the port is lost."""
        port = self._opened()
        try:
            pending = b""
            for item in items:
                if isinstance(item, Break):
                    port.write(pending)
                    _pull_low(port, item.duration_s)
                    pending = b""
                else:
                    pending += item
            port.write(pending)
        except (OSError, termios.error) as error:
            raise self._lost(error) from error

    def read(self, timeout_s: float) -> Sequence[bytes]:
        """What has come in; waits for something at most so long. Raises PortError when the port is lost."""
        port = self._opened()
        try:
            ready, _, _ = select.select([port], [], [], timeout_s)
            # A lost port is ready for ever, with nothing waiting: only a read finds that out.
            chunk = port.read(max(1, min(port.in_waiting, MOST_BYTES))) if ready else b""
        except OSError as error:
            raise self._lost(error) from error
        return (chunk,) if chunk else ()

    def _opened(self) -> "serial.Serial":
        if self._serial is None:
            raise PortError(f"{self._address}: not open")
        return self._serial

    def _lost(self, error: Exception) -> PortError:
        return PortError(f"{self._address}: {self._kind} port lost, was it unplugged? ({error})")


def _pull_low(port: "serial.Serial", duration_s: float) -> None:
    """Send a break, behind what is still on its way."""
    port.flush()
    port.break_condition = True
    try:
        time.sleep(duration_s)
    finally:
        port.break_condition = False


def _hand_over_at_once(port: "serial.Serial") -> None:
    """Have an adapter that can be told so pass on what comes: some keep it to themselves for 16 ms."""
    with suppress(ValueError):
        port.set_low_latency_mode(True)
