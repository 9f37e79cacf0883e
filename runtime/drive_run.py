"""Driving by hand: the wheels alone, asked for one twist, and where the robot came by them."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from echogrid.drivers.bus import NEVER_NS, Port
from echogrid.drivers.clock import Clock, MonotonicClock
from echogrid.drivers.device import BusLine
from echogrid.drivers.readings import Reading, WheelReading
from echogrid.mapping.odometry import Odometry
from echogrid.mapping.pose import Pose
from echogrid.mapping.reckoning import Reckoning
from echogrid.mapping.wheel_pair import WheelPair
from echogrid.runtime import assembly
from echogrid.runtime.acquisition import Acquisition, ThreadedAcquisition
from echogrid.runtime.config import Config
from echogrid.runtime.driving import Driving
from echogrid.runtime.excursion import Excursion, Stage, Wanted
from echogrid.runtime.lines import lines
from echogrid.runtime.loop import FixedRateLoop
from echogrid.runtime.ports import real_ports
from echogrid.runtime.pump import Pump
from echogrid.runtime.reading_queue import ReadingQueue

SHOWN_EVERY_NS = 500_000_000
LEAST_HZ = 20.0
"""More slowly the wheels would stop between ticks, as nobody asked them anew within 200 ms."""


@dataclass(slots=True)
class DriveRun:
    """An excursion under way."""

    excursion: Excursion
    odometry: Odometry
    loop: FixedRateLoop
    acquisition: Acquisition

    def go(self, show: Callable[[Stage, Pose], None]) -> None:
        """Until it is over; `show` is told of each new stage, and where the robot is, twice a second."""
        pair, reckoning = WheelPair(), Reckoning(self.odometry)
        shown_ns, stage = 0, None
        for now_ns in self.loop.ticks(NEVER_NS):
            readings = self.acquisition.drain()
            _reckon(pair, reckoning, readings)
            self.excursion.tick(now_ns, readings, self.acquisition.report(now_ns))
            if self.excursion.stage is not stage or now_ns - shown_ns >= SHOWN_EVERY_NS:
                stage, shown_ns = self.excursion.stage, now_ns
                show(stage, self.odometry.pose)
            if stage is Stage.OVER:
                break
        self.acquisition.stop()


def _reckon(pair: WheelPair, reckoning: Reckoning, readings: Sequence[Reading]) -> None:
    for reading in readings:
        if isinstance(reading, WheelReading):
            for angles in pair.take(reading):
                reckoning.wheels(angles)
    reckoning.poses()


def wheel_lines(config: Config) -> tuple[list[BusLine[Any, Any]], Driving]:
    """The buses of the wheels, which are driven. Raises ConfigError, also for wheels that can't be."""
    alone = replace(config, sensor=(), gyro=())
    driving = Driving(alone, assembly.differential(alone, "driving by command"))
    return lines(alone, driving.throttles), driving


@contextmanager
def driven(config: Config, folder: Path, wanted: Wanted) -> Iterator[DriveRun]:
    """The run on the robot's own ports, ready to go. Raises ConfigError."""
    clock, queue = MonotonicClock(), ReadingQueue()
    devices, driving = wheel_lines(config)
    pumps = pumped(devices, real_ports(config, devices, folder), clock, queue)
    with ThreadedAcquisition(pumps, queue) as acquisition:
        loop = drive_loop(clock, config)
        yield DriveRun(Excursion(driving, wanted), assembly.odometry(config), loop, acquisition)


def drive_loop(clock: Clock, config: Config) -> FixedRateLoop:
    """The loop in which the wheels are asked: the robot's own, unless that is too slow for it."""
    return FixedRateLoop(clock, max(config.loop.rate_hz, LEAST_HZ))


def pumped(
    devices: Sequence[BusLine[Any, Any]], ports: dict[str, Port[Any, Any]], clock: Clock, queue: ReadingQueue
) -> list[Pump[Any, Any]]:
    """A pump for each bus."""
    return [Pump(line, ports[line.name], clock, queue.put) for line in devices]
