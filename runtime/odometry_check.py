"""What calibration does for the odometry of an emulated robot whose wheels are not as robot.toml says.

It is calibrated on squares of 4 m, five in each direction, on which its wheels also slip by chance. It is
judged on others, of 3 m, driven half as fast and without slip: what is left is the systematic error.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from echogrid.drivers.readings import RangeReading
from echogrid.emulation.motion import Limits, Tour
from echogrid.emulation.world import World
from echogrid.mapping.reckoning import YawRate
from echogrid.mapping.wheel_pair import WheelAngles
from echogrid.mapping.wheel_runs import WheelRun, from_squares, square_errors
from echogrid.runtime import assembly
from echogrid.runtime.config import Config, FiringConfig
from echogrid.runtime.hardware_config import RobotConfig
from echogrid.runtime.service import Sink
from echogrid.runtime.simulated_run import simulated_run

BODIES = ((1.003, 0.99), (0.995, 1.02), (1.01, 1.05))
"""The true wheel_ratio, and the true track over the configured one."""
SIDE_M, JUDGED_M = 4.0, 3.0
TIMES = 5
SLIP = 0.0005
"""m: the standard deviation of a wheel's way after 1 m, on a smooth floor."""
_USUAL = Limits()
_SLOW = Limits(speed=0.2, turn_rate=0.5)
_WAIT_S = 1.0
"""A controller is not heard at once."""
_NOWHERE = World("nowhere", np.zeros((0, 4)), np.zeros(0, np.bool_), np.zeros((0, 3)))


@dataclass(slots=True)
class _Wheels:
    """Keeps both wheels' angles."""

    angles: list[tuple[float, float]] = field(default_factory=list)

    def put(
        self, _: tuple[RangeReading, ...], wheels: tuple[WheelAngles, ...], __: tuple[YawRate, ...]
    ) -> None:
        """Append."""
        self.angles += [each.both for each in wheels]


def square(side: float, turn: int, limits: Limits = _USUAL) -> Tour:
    """Once round, and back to how it stood: `turn` 1 is counter-clockwise, -1 clockwise."""
    corners = ((0.0, 0.0), (side, 0.0), (side, turn * side), (0.0, turn * side))
    return Tour(corners, limits=limits, wait=_WAIT_S)


def drive(config: Config, tour: Tour, body: RobotConfig, sink: Sink) -> None:
    """One lap of a robot with that body, its readings to the sink. It stops short of the next lap."""
    run, _ = simulated_run(_barely(config), 1, _NOWHERE, tour, body)
    run.sinks = (sink,)
    run.go(_WAIT_S + tour.lap_time, lambda _: None)


def driven(config: Config, side: float, limits: Limits, body: RobotConfig) -> list[WheelRun]:
    """What the wheels say of a square in each direction."""
    runs = []
    for turn in (-1, 1):
        wheels = _Wheels()
        drive(config, square(side, turn, limits), body, wheels)
        runs.append(WheelRun(np.array(wheels.angles)))
    return runs


def slipped(run: WheelRun, radius: float, random: np.random.Generator) -> WheelRun:
    """The same run with wheels of that radius (m) which slip: a random walk along the way."""
    steps = np.diff(run.angles, axis=0)
    noise = random.normal(size=steps.shape) * SLIP * np.sqrt(abs(steps) / radius)
    return replace(
        run, angles=np.concatenate((run.angles[:1], run.angles[0] + np.cumsum(steps + noise, axis=0)))
    )


def errors(config: Config, ratio: float, track_factor: float, seed: int) -> tuple[float, float]:
    """The worst systematic end error (m) before and after calibration."""
    body = replace(config.robot, wheel_ratio=ratio, track_m=(config.robot.track_m or 0.0) * track_factor)
    before = assembly.differential(config, "this check")
    random = np.random.default_rng(seed)
    runs = driven(config, SIDE_M, _USUAL, body) * TIMES
    after = from_squares([slipped(run, before.left_radius, random) for run in runs], before)
    judged = driven(config, JUDGED_M, _SLOW, body)
    return square_errors(judged, before).worst, square_errors(judged, after).worst


def table(config: Config, seed: int) -> Iterator[str]:
    """Rows of Markdown."""
    yield "| true wheel_ratio, track | worst systematic end error | calibrated | times |"
    yield "|---|---|---|---|"
    for ratio, factor in BODIES:
        old, new = errors(config, ratio, factor, seed)
        errors_cm = f"{100.0 * old:.1f} cm | {100.0 * new:.1f} cm"
        yield f"| {ratio:g}, {100.0 * factor:g} % | {errors_cm} | {old / new:.0f} |"


def _barely(config: Config) -> Config:
    """The robot with its wheels and one ranger."""
    sensor = config.sensor[0]
    needed = {sensor.bus, *(wheel.bus for wheel in config.wheel), *(gyro.bus for gyro in config.gyro)}
    buses = tuple(bus for bus in config.bus if bus.name in needed)
    return replace(config, sensor=(sensor,), bus=buses, firing=FiringConfig())
