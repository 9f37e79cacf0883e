"""How long a reading takes to the command that heeds it, through all bytes, on the real clock.

The emulated robot in another process, on ptys and sockets; here the run, which wanders at 50 Hz.

python -m tests.bench.latency [SECONDS]       (make latency)
"""

import sys
from bisect import bisect_left
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from math import ceil, isnan
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from echogrid.drivers.bus import Port
from echogrid.drivers.clock import MonotonicClock
from echogrid.drivers.readings import RangeReading, Reading
from echogrid.drivers.sound import speed_of_sound
from echogrid.mapping.reckoning import YawRate
from echogrid.mapping.wheel_pair import WheelAngles
from echogrid.runtime import robot_file
from echogrid.runtime.acquisition import ThreadedAcquisition
from echogrid.runtime.emulated import DEFAULT_ROBOT
from echogrid.runtime.emulator_process import emulator
from echogrid.runtime.fusion import Fusion
from echogrid.runtime.live_run import quick_threads
from echogrid.runtime.loop import FixedRateLoop
from echogrid.runtime.modes import making
from echogrid.runtime.ports import real_ports
from echogrid.runtime.pump import Pump
from echogrid.runtime.reading_queue import ReadingQueue
from echogrid.runtime.service import Run
from echogrid.runtime.voyage import commissioned

_CLOCK = MonotonicClock()
_WHEELS = "wheel_bus"
_SECONDS = 30.0


class TimedPort:
    """Knows when something came last, and when something was written."""

    def __init__(self, port: Port[Any, Any]) -> None:
        self.read_ns = 0
        self.written_ns: list[int] = []
        self._port = port

    def open(self) -> None:
        """As the port."""
        self._port.open()

    def close(self) -> None:
        """As the port."""
        self._port.close()

    def read(self, timeout_s: float) -> Sequence[Any]:
        """As the port."""
        data = self._port.read(timeout_s)
        if data:
            self.read_ns = _CLOCK.now_ns()
        return data

    def write(self, items: Sequence[Any]) -> None:
        """As the port."""
        self._port.write(items)
        self.written_ns.append(_CLOCK.now_ns())


@dataclass
class Watch:
    """Takes the times of each reading while the robot moves: when its bus's thread has it, and at the end of
    the tick that took it."""

    fusion: Fusion
    queue: ReadingQueue
    sound: float
    """m/s."""
    read_ns: dict[int, int] = field(default_factory=dict)
    heeded: list[tuple[RangeReading, int, int]] = field(default_factory=list)
    """With the time of its last byte, and of the command."""

    def deliver(self, port: TimedPort) -> Callable[[tuple[Reading, ...]], None]:
        """What a pump shall do with its readings."""

        def put(readings: tuple[Reading, ...]) -> None:
            self.read_ns |= {id(each): port.read_ns for each in readings if isinstance(each, RangeReading)}
            self.queue.put(readings)

        return put

    def put(
        self, ranges: tuple[RangeReading, ...], _: tuple[WheelAngles, ...], _rates: tuple[YawRate, ...]
    ) -> None:
        """The motors have just been asked."""
        now_ns = _CLOCK.now_ns()
        taken = [(each, self.read_ns.pop(id(each)), now_ns) for each in ranges]
        self.heeded += taken if not self.fusion.twist.stands else []

    def ping_ms(self, reading: RangeReading, asked_ns: int) -> float:
        """Since it was fired, by the driver's own stamp, which is that of the echo at the obstacle."""
        return (asked_ns - reading.stamp_ns) * 1e-6 + reading.distance / self.sound * 1e3


def main() -> None:
    """Print a table."""
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else _SECONDS
    config = robot_file.load(DEFAULT_ROBOT)
    with ExitStack() as stack:
        folder = Path(stack.enter_context(TemporaryDirectory(prefix="eg", dir="/tmp")))
        stack.enter_context(emulator(folder, 1, driven=True))
        lines, fusion, voyage = commissioned(config, making.wander(config, 1))
        ports = {name: TimedPort(port) for name, port in real_ports(config, lines, folder).items()}
        watch = Watch(fusion, ReadingQueue(), speed_of_sound(config.robot.air_temperature_c))
        pumps = [Pump(line, ports[line.name], _CLOCK, watch.deliver(ports[line.name])) for line in lines]
        stack.enter_context(quick_threads())
        acquisition = stack.enter_context(ThreadedAcquisition(pumps, watch.queue))
        loop = FixedRateLoop(_CLOCK, config.loop.rate_hz)
        run = Run(fusion, loop, acquisition, _CLOCK, (watch,), voyage=voyage)
        run.go(seconds, lambda _: None)
    print(
        f"{run.travelled:.1f} m driven, {len(watch.heeded)} readings, {100 * loop.punctuality:.1f} % in time"
    )
    print("| from | to | readings | p50 ms | p99 ms | longest ms |\n|---|---|---|---|---|---|")
    _tell(watch, ports[_WHEELS].written_ns)


def _tell(watch: Watch, written_ns: Sequence[int]) -> None:
    asked = [(asked_ns - read_ns) * 1e-6 for _, read_ns, asked_ns in watch.heeded]
    _row("last byte", "command asked for", asked)
    after = ((read_ns, bisect_left(written_ns, asked_ns)) for _, read_ns, asked_ns in watch.heeded)
    written = [(written_ns[index] - read_ns) * 1e-6 for read_ns, index in after if index < len(written_ns)]
    _row("last byte", "next frame to the motors written", written)
    for kind, make in (("ring_", "srf08"), ("front_", "a02yyuw"), ("rear_", "a02yyuw")):
        pings = [
            watch.ping_ms(reading, asked_ns)
            for reading, _, asked_ns in watch.heeded
            if reading.sensor.startswith(kind) and not isnan(reading.distance)
        ]
        _row(f"ping of {kind}* ({make})", "command asked for", pings)


def _row(start: str, end: str, times_ms: Sequence[float]) -> None:
    ordered = sorted(times_ms)
    if ordered:
        p50, p99 = (ordered[ceil(part * len(ordered)) - 1] for part in (0.5, 0.99))
        print(f"| {start} | {end} | {len(ordered)} | {p50:.1f} | {p99:.1f} | {ordered[-1]:.1f} |")


if __name__ == "__main__":
    main()
