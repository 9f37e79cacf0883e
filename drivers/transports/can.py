"""CAN ports, by any interface of python-can."""

import contextlib
import select
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from echogrid.drivers.bus import CanFrame
from echogrid.drivers.errors import PortError
from echogrid.drivers.limits import require_between
from echogrid.drivers.transports.mend import cannot_open
from echogrid.drivers.transports.wall_stamp import WallStamps

if TYPE_CHECKING:
    import can

MOST_FRAMES = 1000
"""One read takes no more, so that a babbling bus cannot hold its thread."""
SEND_WITHIN_S = 0.1
SLCAN: Mapping[str, object] = {"sleep_after_open": 0, "timeout": 0}
"""No pause, and no wait in the reads: they come when there is something to read."""
STAMPED_BY_THE_KERNEL = ("socketcan",)
"""Interfaces whose messages bear the time when they came, of the wall clock."""


class CanPort:
    """A CAN bus. Frames that are no classic data or remote frames are counted and dropped.

    A frame's stamp is the kernel's where it gives one, else the time when it was read.
    """

    def __init__(
        self,
        address: str,
        *,
        interface: str = "socketcan",
        bitrate: int = 250_000,
        more: Mapping[str, object] = MappingProxyType({}),
    ) -> None:
        """`interface` is python-can's name for it, `more` what else python-can shall be told about it."""
        require_between("bitrate", bitrate, 10_000, 1_000_000)
        self._address = address
        quick = SLCAN if interface == "slcan" else {}
        self._options: dict[str, Any] = {"interface": interface, "bitrate": bitrate, **quick, **more}
        self._bus: can.BusABC | None = None
        self._descriptor: int | None = None
        self._stamps = WallStamps() if interface in STAMPED_BY_THE_KERNEL else None
        self.counts: Counter[str] = Counter()

    def open(self) -> None:
        """Make ready. Raises PortError, which names the port and the mend."""
        import can

        self.close()
        try:
            self._bus = can.Bus(channel=self._address, ignore_config=True, **self._options)
        except (can.CanError, OSError, ValueError, TypeError, NotImplementedError) as error:
            raise self._cannot_open(error) from error
        try:
            self._descriptor = self._bus.fileno()
        except NotImplementedError:
            self._descriptor = None

    def close(self) -> None:
        """Let go. May be called twice."""
        bus, self._bus, self._descriptor = self._bus, None, None
        if bus is None:
            return
        import can
        from can.interfaces.slcan import slcanBus

        # An unplugged adapter cannot be told that it is closed.
        with contextlib.suppress(can.CanError, OSError):
            bus.shutdown()
        if isinstance(bus, slcanBus):
            bus.serialPortOrig.close()

    def write(self, items: Sequence[CanFrame]) -> None:
        """Send. Raises PortError when the port is lost."""
        import can

        bus = self._opened()
        try:
            for frame in items:
                bus.send(_message(frame), SEND_WITHIN_S)
        except (can.CanError, OSError) as error:
            raise self._lost(error) from error

    def read(self, timeout_s: float) -> Sequence[CanFrame]:
        """What has come in; waits for something at most so long. Raises PortError when the port is lost."""
        import can

        try:
            return self._drain(self._opened(), timeout_s)
        except (can.CanError, OSError) as error:
            raise self._lost(error) from error

    def _drain(self, bus: "can.BusABC", wait_s: float) -> list[CanFrame]:
        """All that is pending, after a wait for the first."""
        frames: list[CanFrame] = []
        if self._descriptor is not None:
            select.select([self._descriptor], [], [], wait_s)
            wait_s = 0.0
        if self._stamps is not None:
            self._stamps.check()
        for _ in range(MOST_FRAMES):
            message, noise = self._receive(bus, wait_s)
            wait_s = 0.0
            if message is not None and (frame := self._frame(message)):
                frames.append(frame)
            elif message is None and not noise:
                break
        return frames

    def _receive(self, bus: "can.BusABC", wait_s: float) -> tuple["can.Message | None", bool]:
        """A message, if one came, and whether noise came in its place: slcan's lines are not checked."""
        import can

        try:
            return bus.recv(wait_s), False
        except (ValueError, LookupError):
            pass
        except can.CanError as error:
            if not isinstance(error.__cause__, UnicodeError):
                raise
            # The line that is no text stays in slcan's buffer, before all that follow.
            _flush(bus)
        self.counts["malformed lines"] += 1
        return None, True

    def _frame(self, message: "can.Message") -> CanFrame | None:
        stamp_ns = self._stamp_ns(message)
        data = bytes(message.data)
        highest = 0x1FFF_FFFF if message.is_extended_id else 0x7FF
        whole = message.is_remote_frame or message.dlc == len(data) <= 8
        if message.is_error_frame:
            self.counts["error frames"] += 1
        elif message.is_fd or not whole or not 0 <= message.arbitration_id <= highest:
            self.counts["malformed frames"] += 1
        else:
            return CanFrame(
                message.arbitration_id, data, message.is_extended_id, message.is_remote_frame, stamp_ns
            )
        return None

    def _stamp_ns(self, message: "can.Message") -> int:
        now_ns = time.monotonic_ns()
        if self._stamps is None:
            return now_ns
        return self._stamps.monotonic_ns(round(message.timestamp * 1e9), now_ns)

    def _opened(self) -> "can.BusABC":
        if self._bus is None:
            raise PortError(f"{self._address}: not open")
        return self._bus

    def _cannot_open(self, error: Exception) -> PortError:
        if self._options["interface"] == "socketcan" and Path(self._address).is_char_device():
            mend = 'it is a serial port: say interface = "slcan"'
            return PortError(f"{self._address}: cannot open this CAN port: {mend}")
        return cannot_open("CAN", self._address, "dialout", error)

    def _lost(self, error: Exception) -> PortError:
        return PortError(f"{self._address}: CAN port lost, was it unplugged or set down? ({error})")


def _flush(bus: "can.BusABC") -> None:
    from can.interfaces.slcan import slcanBus

    if isinstance(bus, slcanBus):
        bus.flush()


def _message(frame: CanFrame) -> "can.Message":
    import can

    return can.Message(
        arbitration_id=frame.identifier,
        data=frame.data,
        is_extended_id=frame.extended,
        is_remote_frame=frame.remote,
    )
