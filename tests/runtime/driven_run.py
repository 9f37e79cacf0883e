"""The built-in robot, driven by a mode on a clock that jumps, through all bytes, in a room of one's own."""

import json
import socket
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from socket import MSG_DONTWAIT

import numpy as np

from echogrid.drivers.readings import RangeReading
from echogrid.emulation.floor_plan import FloorPlan, Rectangle
from echogrid.emulation.motion import Tour
from echogrid.emulation.robot import EmulatedRobot
from echogrid.emulation.world import World
from echogrid.emulation.worlds.furnishing import Furnishing
from echogrid.mapping.pose import Pose
from echogrid.mapping.reckoning import YawRate
from echogrid.mapping.twist import Twist
from echogrid.mapping.wheel_pair import WheelAngles
from echogrid.runtime.config import Config
from echogrid.runtime.hull import footprint
from echogrid.runtime.loop import SECOND_NS
from echogrid.runtime.modes.mode import Mode
from echogrid.runtime.service import Run
from echogrid.runtime.simulated_run import simulated_run
from echogrid.runtime.status import Status
from echogrid.runtime.voyage import Voyage

START = Pose(1.5, 2.5)
"""In the room, which is 8 m by 5 m; it looks along the long side."""
_TOUR = Tour(((1.5, 2.5), (3.0, 2.5), (3.0, 3.0)))


def room(*furniture: Rectangle) -> World:
    """With upright boxes in it."""
    return Furnishing().world("room", FloorPlan(((0.0, 0.0, 8.0, 5.0),), furniture))


@dataclass
class Wisher:
    """Sends its wish to a source of wishes at each tick; None: nothing."""

    address: Path
    wish: Twist | None = None
    sender: socket.socket = field(default_factory=lambda: socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM))

    def put(
        self, _: tuple[RangeReading, ...], _wheels: tuple[WheelAngles, ...], _rates: tuple[YawRate, ...]
    ) -> None:
        if self.wish:
            wanted = {"speed": self.wish.speed, "turn_rate": self.wish.turn_rate}
            with suppress(BlockingIOError):  # Nobody hears while the robot pauses.
                self.sender.sendto(json.dumps(wanted).encode(), MSG_DONTWAIT, str(self.address))


class Drive:
    """The run, where the robot was, and what it was asked for."""

    def __init__(self, config: Config, mode: Mode, world: World, wisher: Wisher | None = None) -> None:
        made: tuple[Run, EmulatedRobot] = simulated_run(config, 1, world, _TOUR, mode=mode)
        self.run, self.robot = made
        assert self.run.voyage
        self.voyage: Voyage = self.run.voyage
        self.run.sinks = (self,) if wisher is None else (self, wisher)
        self.poses: list[Pose] = []
        self.asked: list[Twist] = []
        self.told: list[str] = []
        self._world = world
        self._radius = footprint(config).reach
        self._ticks = self.run.loop.ticks(1 << 62)

    def put(
        self, _: tuple[RangeReading, ...], _wheels: tuple[WheelAngles, ...], _rates: tuple[YawRate, ...]
    ) -> None:
        self.poses.append(START.compose(self.run.fusion.odometry.pose))
        self.asked.append(self.run.fusion.twist)
        self.told.append(self.voyage.told)

    @property
    def now_ns(self) -> int:
        return self.run.clock.now_ns()

    def go(self, duration_s: float) -> None:
        """To its end, or that of the time, whatever comes first; then it is stopped."""
        self.run.go(duration_s, self._show)

    def live(self, seconds: float) -> None:
        """For so long, and no end."""
        until_ns = self.now_ns + round(seconds * SECOND_NS)
        while self.now_ns < until_ns:
            now_ns = next(self._ticks)
            self.run._tick(now_ns, self.run.acquisition.drain())

    def pause(self, seconds: float) -> None:
        """Nobody ticks; buses go on."""
        self.run.loop.clock.sleep_until_ns(self.now_ns + round(seconds * SECOND_NS))

    def nearest(self) -> float:
        """m that were left between the circle around the robot and anything, at the least."""
        places = np.array([(pose.x, pose.y) for pose in self.poses])
        return float(self._world.surface_distance(places).min()) - self._radius

    def _show(self, _: Status) -> None:
        pass
