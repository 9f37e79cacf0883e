"""Receives echogrid's obstacle view, and says STOP whenever it may not be relied upon.

python3 obstacle_receiver.py unix:/run/robot/obstacles.sock
python3 obstacle_receiver.py udp:0.0.0.0:7654 --timeout-ms 200

One line for each change: GO with the speed limit, STOP with the reason; and how many frames were lost.
It needs nothing but Python. The layout is that of docs/obstacle-sensor.md.
"""

import argparse
import contextlib
import socket
import struct
import sys
import time
import zlib
from dataclasses import dataclass
from pathlib import Path

HEADER = struct.Struct("<4sBBBBIHHQIIfffffffB3x")
CHECK_BYTES = 4
SECTOR_BYTES = 8
STOP = 1
REASONS = {0: "", 1: "near", 2: "silent", 3: "unknown", 4: "stale"}
LONGEST = 65535


@dataclass(frozen=True)
class Frame:
    """What a motor controller needs of a datagram."""

    sequence: int
    stamp_ns: int
    stop: bool
    reason: str
    speed_limit: float


def decoded(data: bytes) -> Frame | None:
    """The frame, or None for anything that is not exactly one of version 1."""
    if len(data) < HEADER.size + CHECK_BYTES or data[:4] != b"EGOV" or data[4] != 1:
        return None
    _, _, flags, reason, _, sequence, length, sectors, stamp_ns, _, _, limit, *_ = HEADER.unpack_from(data)
    if length != len(data) or length != HEADER.size + SECTOR_BYTES * sectors + CHECK_BYTES:
        return None
    if zlib.crc32(data[:-CHECK_BYTES]) != int.from_bytes(data[-CHECK_BYTES:], "little"):
        return None
    return Frame(sequence, stamp_ns, bool(flags & STOP), REASONS.get(reason, "unknown reason"), limit)


class Watch:
    """What may be done, by the last frame and the time since it came."""

    def __init__(self, timeout_s: float, one_clock: bool) -> None:
        """`one_clock`: the sender runs on this machine, so that stamps tell how old a frame is."""
        self.lost = 0
        self._timeout_s = timeout_s
        self._one_clock = one_clock
        self._last: Frame | None = None
        self._heard_s = 0.0
        self._why = "no valid frame yet"

    def take(self, data: bytes, now_s: float) -> int:
        """A datagram; how many before it were lost. What is invalid or old changes nothing."""
        frame = decoded(data)
        if frame is None or self._is_old(frame, now_s):
            return 0
        lost = 0
        if self._last is not None:
            if frame.stamp_ns <= self._last.stamp_ns:
                return 0  # a repeated one, or one that was overtaken
            ahead = (frame.sequence - self._last.sequence - 1) % (1 << 32)
            lost = ahead if ahead < 1 << 31 else 0  # a sender that was started anew counts from 0
        self._last, self._heard_s = frame, now_s
        self.lost += lost
        return lost

    def verdict(self, now_s: float) -> str:
        """GO or STOP, and why."""
        if self._last is not None and now_s - self._heard_s > self._timeout_s:
            self._last = None  # whoever speaks next is believed, whatever its clock says
            self._why = f"no valid frame for {self._timeout_s * 1e3:.0f} ms"
        if self._last is None:
            return f"STOP {self._why}"
        if self._last.stop:
            return f"STOP {self._last.reason}"
        return f"GO {self._last.speed_limit:.2f} m/s"

    def _is_old(self, frame: Frame, now_s: float) -> bool:
        return self._one_clock and now_s - frame.stamp_ns * 1e-9 > self._timeout_s


def receiving(address: str) -> socket.socket:
    """A socket bound to unix:PATH or udp:HOST:PORT; one that is left of an earlier run is removed."""
    kind, _, place = address.partition(":")
    if kind == "unix":
        path = Path(place)
        if path.is_socket():
            path.unlink()
        bound = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        bound.bind(place)
        return bound
    host, _, port = place.rpartition(":")
    bound = socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET, socket.SOCK_DGRAM)
    bound.bind((host, int(port)))
    return bound


def main() -> None:
    """Listen until interrupted."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("address", metavar="unix:PATH|udp:HOST:PORT")
    parser.add_argument("--timeout-ms", type=float, default=200.0)
    arguments = parser.parse_args()
    timeout_s = arguments.timeout_ms * 1e-3
    watch = Watch(timeout_s, one_clock=arguments.address.startswith("unix:"))
    shown = ""
    with receiving(arguments.address) as bound:
        bound.settimeout(timeout_s / 4.0)
        while True:
            verdict = watch.verdict(time.monotonic())
            if verdict != shown:
                print(verdict, flush=True)
                shown = verdict
            with contextlib.suppress(TimeoutError):
                if lost := watch.take(bound.recv(LONGEST), time.monotonic()):
                    print(f"LOST {lost}", flush=True)


if __name__ == "__main__":
    with contextlib.suppress(KeyboardInterrupt):
        sys.exit(main())
