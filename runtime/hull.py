"""The robot's outline: as configured, or a box around its wheels and rangers."""

from echogrid.mapping.footprint import Footprint
from echogrid.runtime.config import Config

_TYRE_M = 0.02
"""Half the width of a wheel whose width nobody told."""
_LEAST_M = 0.05


def footprint(config: Config) -> Footprint:
    """That of the configured robot.

    The box holds the wheels, of a steered drive also the steered one, and every transducer. It is a guess: it
    knows nothing of bumpers and arms.
    """
    robot = config.robot
    if robot.footprint:
        return Footprint([(x, y) for x, y in robot.footprint])
    radius = max(robot.wheel_radius_m or 0.0, _LEAST_M)
    length = robot.wheelbase_m or 0.0
    side = (robot.track_m or length) / 2.0 + _TYRE_M
    xs = [-radius, length + radius, *(sensor.x_m for sensor in config.sensor)]
    ys = [side, _LEAST_M, *(abs(sensor.y_m) for sensor in config.sensor)]
    return Footprint.box(min(xs), max(xs), max(ys))
