"""Dead reckoning of a differential drive from the absolute angles of its two wheels."""

from dataclasses import dataclass, field
from math import cos, sin

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.pose import Pose, wrap_angle

_STRAIGHT = 1e-6
"""rad: a smaller turn is driven straight, where the arc's radius would lose all digits."""


def midpoint_step(pose: Pose, left: float, right: float, track: float) -> Pose:
    """The pose after the wheels rolled `left` and `right` metres, by the midpoint rule.

    It moves along the mean heading: x += ds cos(yaw + dyaw/2). Its Jacobians are those of `propagate`.
    """
    forward, turn = (right + left) / 2.0, (right - left) / track
    heading = pose.yaw + turn / 2.0
    return Pose(pose.x + forward * cos(heading), pose.y + forward * sin(heading), wrap_angle(pose.yaw + turn))


def arc_step(pose: Pose, left: float, right: float, track: float) -> Pose:
    """The pose after the wheels rolled `left` and `right` metres, along the exact circular arc."""
    turn = (right - left) / track
    if abs(turn) <= _STRAIGHT:
        return midpoint_step(pose, left, right, track)
    radius = (right + left) / 2.0 / turn
    yaw = pose.yaw + turn
    return Pose(
        pose.x + radius * (sin(yaw) - sin(pose.yaw)),
        pose.y - radius * (cos(yaw) - cos(pose.yaw)),
        wrap_angle(yaw),
    )


def propagate(
    covariance: NDArray[np.float64], pose: Pose, left: float, right: float, track: float, spread: float
) -> NDArray[np.float64]:
    """The (3, 3) covariance of x, y, yaw after a step from `pose`.

    P' = F P F' + V Q V' with Q = diag(spread |right|, spread |left|), `spread` in m^2 per m of each wheel's
    way (Chong & Kleeman 1997).
    """
    forward, turn = (right + left) / 2.0, (right - left) / track
    heading = pose.yaw + turn / 2.0
    c, s = cos(heading), sin(heading)
    state = np.array([[1.0, 0.0, -forward * s], [0.0, 1.0, forward * c], [0.0, 0.0, 1.0]])
    lean = forward / (2.0 * track)
    wheels = np.array(
        [
            [c / 2.0 - lean * s, c / 2.0 + lean * s],
            [s / 2.0 + lean * c, s / 2.0 - lean * c],
            [1.0 / track, -1.0 / track],
        ]
    )
    noise = np.diag([spread * abs(right), spread * abs(left)])
    result: NDArray[np.float64] = state @ covariance @ state.T + wheels @ noise @ wheels.T
    return result


@dataclass(slots=True)
class DifferentialDrive:
    """The pose in the odom frame, from where the wheels were first seen."""

    wheel_radius: float
    track: float
    pose: Pose = field(default_factory=Pose)
    travelled: float = 0.0
    """m, the length of the path."""
    _angles: tuple[float, float] | None = None

    def update(self, left: float, right: float) -> Pose:
        """The pose now that the wheels stand at these absolute angles (rad)."""
        if self._angles is not None:
            rolled_left = (left - self._angles[0]) * self.wheel_radius
            rolled_right = (right - self._angles[1]) * self.wheel_radius
            self.pose = arc_step(self.pose, rolled_left, rolled_right, self.track)
            self.travelled += abs(rolled_left + rolled_right) / 2.0
        self._angles = left, right
        return self.pose
