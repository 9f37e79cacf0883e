"""The built-in robot with few rangers and a gyro, and what is done to it while it drives."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from echogrid.drivers.readings import RangeReading
from echogrid.emulation.robot import EmulatedRobot
from echogrid.mapping.reckoning import YawRate
from echogrid.mapping.wheel_pair import WheelAngles
from echogrid.runtime.emulated import DEFAULT_ROBOT
from echogrid.runtime.loop import SECOND_NS
from echogrid.runtime.service import Run
from echogrid.runtime.simulated_run import START_NS

GYRO = """
[[bus]]
name = "gyro_line"
kind = "serial"
port = "gyro_line"

[[gyro]]
name = "gyro"
driver = "gyro-text"
bus = "gyro_line"
key = "gz="
scale = -1.0
"""
ROBOT = DEFAULT_ROBOT.read_text() + GYRO

Mishap = tuple[float, str, str, float]
"""When (s), to whom, what, for how long (s)."""


@dataclass(slots=True)
class Mishaps:
    """A sink that lets things happen at their times."""

    run: Run
    robot: EmulatedRobot
    planned: Sequence[Mishap]
    happened: set[Mishap] = field(default_factory=set)

    def put(self, _: tuple[RangeReading, ...], __: tuple[WheelAngles, ...], ___: tuple[YawRate, ...]) -> None:
        """Look at the clock."""
        now_ns = self.run.clock.now_ns()
        for mishap in self.planned:
            at_s, name, verb, for_s = mishap
            if mishap not in self.happened and now_ns >= START_NS + at_s * SECOND_NS:
                self.happened.add(mishap)
                self.robot.fault(name, verb, now_ns, round(for_s * SECOND_NS))
