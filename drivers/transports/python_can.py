"""A CAN bus by any interface of python-can."""

import contextlib
import select
import time
from collections import Counter, deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from errno import EAGAIN, ENOBUFS
from pathlib import Path
from typing import TYPE_CHECKING, Any

from echogrid.drivers.bus import FD_LENGTHS, CanFrame
from echogrid.drivers.errors import PortError
from echogrid.drivers.transports.fd_rates import DATA_BITRATE, SAMPLE_POINT
from echogrid.drivers.transports.mend import cannot_open
from echogrid.drivers.transports.wall_stamp import WallStamps

if TYPE_CHECKING:
    import can

MOST_FRAMES = 1000
"""One read takes no more, so that a babbling bus cannot hold its thread."""
SEND_WITHIN_S = 0.1
STAMPED_BY_THE_KERNEL = ("socketcan", "udp_multicast")
"""Interfaces whose messages bear the time when they came, of the wall clock."""
HEARD_BY_THE_SENDER = ("udp_multicast",)
"""Interfaces on which the sender gets its own frames, though no CAN bus does so."""
ANYONE_MAY_SEND = ("udp_multicast",)
"""Interfaces on which what comes need not be a frame at all."""
MOST_ECHOES = 100
SET_UP_ELSEWHERE = ("socketcan", "virtual", "udp_multicast")
"""Interfaces that have no bit rate of their own to be told."""
FD_CLOCK_HZ = 80_000_000
"""From which an adapter makes its bit rates; python-can finds the nearest one that it has."""
CONGESTED = (None, ENOBUFS, EAGAIN)
"""Codes of a refusal to send which is none of the port's: the queue is full, or stayed so too long."""


class PythonCanChannel:
    """Frames that are neither data nor remote frames are counted and dropped, and so are those of CAN-FD
    unless it was asked for.

    A frame's stamp is the kernel's where it gives one, else the time when it was read.
    """

    def __init__(
        self,
        address: str,
        options: Mapping[str, Any],
        counts: Counter[str],
        erred: Callable[[int, bytes], None],
    ) -> None:
        """`options` are those of python-can, with `fd` for CAN-FD; `erred` is told the identifier and data
        of error frames."""
        self._address = address
        self._options = options
        self._fd = bool(options.get("fd"))
        self._counts = counts
        self._erred = erred
        self._bus: can.BusABC | None = None
        self._descriptor: int | None = None
        interface = options["interface"]
        self._stamps = WallStamps() if interface in STAMPED_BY_THE_KERNEL else None
        self._echoed = interface in HEARD_BY_THE_SENDER
        self._own: deque[CanFrame] = deque(maxlen=MOST_ECHOES)
        self._anything = interface in ANYONE_MAY_SEND

    def open(self) -> None:
        """Make ready. Raises PortError, which names the port and the mend."""
        import can

        try:
            options = self._fd_options() if self._fd else self._options
            self._bus = can.Bus(channel=self._address, ignore_config=True, **options)
        except (can.CanError, OSError, ValueError, TypeError, NotImplementedError) as error:
            raise self._cannot_open(error) from error
        if self._fd and self._bus.protocol is can.CanProtocol.CAN_20:
            self.close()
            what = f"python-can's {self._options['interface']} has no CAN-FD: use socketcan, and an adapter"
            raise PortError(f"{self._address}: cannot open this CAN port: {what} that the kernel knows")
        try:
            self._descriptor = self._bus.fileno()
        except NotImplementedError:
            self._descriptor = None

    def _fd_options(self) -> Mapping[str, Any]:
        """What python-can wants to be told for CAN-FD: how, differs by interface."""
        import can

        interface = self._options["interface"]
        if interface == "virtual":
            return {"protocol": can.CanProtocol.CAN_FD, **self._options}
        if interface in SET_UP_ELSEWHERE:
            return self._options
        timing = can.BitTimingFd.from_sample_point(
            f_clock=FD_CLOCK_HZ,
            nom_bitrate=self._options["bitrate"],
            nom_sample_point=SAMPLE_POINT,
            data_bitrate=DATA_BITRATE,
            data_sample_point=SAMPLE_POINT,
        )
        return {"timing": timing, "data_bitrate": DATA_BITRATE, **self._options}

    def _cannot_open(self, error: Exception) -> PortError:
        if self._options["interface"] == "socketcan" and Path(self._address).is_char_device():
            mend = 'it is a serial port: say interface = "slcan"'
            return PortError(f"{self._address}: cannot open this CAN port: {mend}")
        return cannot_open("CAN", self._address, "dialout", error)

    def close(self) -> None:
        """Let go. May be called twice."""
        bus, self._bus, self._descriptor = self._bus, None, None
        if bus is None:
            return
        import can

        # What is unplugged cannot be told that it is closed.
        with contextlib.suppress(can.CanError, OSError):
            bus.shutdown()

    def send(self, frames: Sequence[CanFrame]) -> int:
        """Send; how many were, before the queue was full. Raises PortError when the port is lost."""
        import can

        bus = self._opened()
        for number, frame in enumerate(frames):
            try:
                bus.send(_message(frame), SEND_WITHIN_S)
            except (can.CanError, OSError) as error:
                if _errno(error) in CONGESTED:
                    return number
                raise self._lost(error) from error
            if self._echoed:
                self._own.append(replace(frame, stamp_ns=0))
        return len(frames)

    def receive(self, wait_s: float) -> list[CanFrame]:
        """What has come in. Raises PortError when the port is lost."""
        import can

        try:
            return self._drain(self._opened(), wait_s)
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
        """A message, if one came, and whether noise came in its place: not every interface checks for it."""
        import can

        try:
            return bus.recv(wait_s), False
        except (ValueError, LookupError):
            pass
        except can.CanError as error:
            if not self._anything or _errno(error) is not None:
                raise
        self._counts["malformed frames"] += 1
        return None, True

    def _frame(self, message: "can.Message") -> CanFrame | None:
        data = bytes(message.data)
        highest = 0x1FFF_FFFF if message.is_extended_id else 0x7FF
        if message.is_fd:
            whole = self._fd and not message.is_remote_frame and message.dlc == len(data) in FD_LENGTHS
        else:
            whole = message.is_remote_frame or message.dlc == len(data) <= 8
        if message.is_error_frame:
            self._counts["error frames"] += 1
            self._erred(message.arbitration_id, data)
        elif not whole or not 0 <= message.arbitration_id <= highest:
            self._counts["malformed frames"] += 1
        else:
            stamp_ns = self._stamp_ns(message)
            frame = CanFrame(
                message.arbitration_id,
                data,
                message.is_extended_id,
                message.is_remote_frame,
                stamp_ns,
                message.is_fd,
            )
            return None if self._is_own(frame) else frame
        return None

    def _is_own(self, frame: CanFrame) -> bool:
        """Whether it is one that was sent here; each comes back once."""
        sent = replace(frame, stamp_ns=0) if self._own else None
        if sent is None or sent not in self._own:
            return False
        self._own.remove(sent)
        return True

    def _stamp_ns(self, message: "can.Message") -> int:
        now_ns = time.monotonic_ns()
        if self._stamps is None:
            return now_ns
        return self._stamps.monotonic_ns(round(message.timestamp * 1e9), now_ns)

    def _opened(self) -> "can.BusABC":
        if self._bus is None:
            raise PortError(f"{self._address}: not open")
        return self._bus

    def _lost(self, error: Exception) -> PortError:
        return PortError(f"{self._address}: CAN port lost, was it unplugged or set down? ({error})")


def _message(frame: CanFrame) -> "can.Message":
    import can

    return can.Message(
        arbitration_id=frame.identifier,
        data=frame.data,
        is_extended_id=frame.extended,
        is_remote_frame=frame.remote,
        is_fd=frame.fd,
        bitrate_switch=frame.fd,
    )


def _errno(error: Exception) -> int | None:
    """The errno of the error or of the one behind it."""
    import can

    if isinstance(error, can.CanError) and error.error_code is not None:
        return error.error_code
    cause = error if isinstance(error, OSError) else error.__cause__
    return cause.errno if isinstance(cause, OSError) else None
