"""Where a robot is on a floor plan: an extended Kalman filter over odometry and the echoes of known walls.

Leonard & Durrant-Whyte, Directed Sonar Sensing for Mobile Robot Navigation (1992). The start is known; who is
put elsewhere is not found again.
"""

from dataclasses import dataclass
from math import cos, hypot, radians, sin, tan

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.placed_ping import PlacedPing
from echogrid.mapping.planning.floor_plan import FloorPlan, Points, placed
from echogrid.mapping.pose import Pose, wrap_angle
from echogrid.mapping.verification import heard_at

_AROUND = tan(radians(28.0))
"""A wall answers at right angles: if something so much farther aside is nearer, it was not that."""


@dataclass(frozen=True, slots=True)
class Trust:
    """How good odometry, echoes and plan are, as standard deviations."""

    start: tuple[float, float, float] = (0.01, 0.01, 0.003)
    """m, m and rad."""
    ahead: float = 0.02
    """m after a metre; it grows with the root of the way, as do the next two."""
    aside: float = 0.005
    yaw: float = 0.01
    """rad after a metre."""
    turn: float = 0.03
    """rad after a radian that was turned."""
    echo: float = 0.02
    """m, and ..."""
    echo_part: float = 0.01
    """... this part of the distance."""
    gate: float = 3.0
    """So many standard deviations off is another thing."""
    farthest: float = 3.0
    """m: farther echoes say nothing of where the robot is."""
    band: float = 0.12
    """m: a wall is known at the distance of an echo if the plan has one no farther from it than this."""
    lost: float = 0.35
    """If no greater part of the echoes of walls was within the gate lately, the robot is elsewhere."""
    lately: float = 100.0
    """Echoes."""


class PlanTracker:
    """One thread owns it."""

    def __init__(self, plan: FloorPlan, start: Pose, trust: Trust | None = None) -> None:
        """`start` is the robot's pose on the plan where its odometry begins, at zero."""
        self.plan = plan
        self.pose = start
        """Of the robot (plan's frame)."""
        self.drift = start
        """Of the odom frame in the plan's."""
        self._trust = trust or Trust()
        self._covariance: NDArray[np.float64] = np.diag(np.square(self._trust.start))
        self._odometry = Pose()
        self._matching = 1.0

    @property
    def is_lost(self) -> bool:
        """Whether the echoes do not fit the plan."""
        return self._matching < self._trust.lost

    @property
    def deviation(self) -> tuple[float, float, float]:
        """m, m and rad: the standard deviations of the pose."""
        x, y, yaw = np.sqrt(self._covariance.diagonal()).tolist()
        return x, y, yaw

    def move(self, odometry: Pose) -> None:
        """Follow the wheels (odom frame)."""
        step = self._odometry.inverse().compose(odometry)
        way, turn = hypot(step.x, step.y), abs(step.yaw)
        self._odometry = odometry
        if not way and not turn:
            return
        trust, c, s = self._trust, cos(self.pose.yaw), sin(self.pose.yaw)
        moved = np.eye(3)
        moved[0, 2], moved[1, 2] = -s * step.x - c * step.y, c * step.x - s * step.y
        along, across = trust.ahead**2 * way, trust.aside**2 * way
        noise = np.zeros((3, 3))
        noise[0, 0], noise[1, 1] = c * c * along + s * s * across, s * s * along + c * c * across
        noise[0, 1] = noise[1, 0] = c * s * (along - across)
        noise[2, 2] = trust.yaw**2 * way + trust.turn**2 * turn
        self._covariance = moved @ self._covariance @ moved.T + noise
        self._be(self.pose.compose(step))

    def explains(self, ping: PlacedPing) -> bool:
        """Whether the plan has a wall where an echo came from (its transducer in the odom frame); what it
        tells of where the robot is, is learned."""
        distance = heard_at(ping)
        if distance is None:
            return False
        at = self.drift.compose(ping.transducer)
        walls = self.plan.near(at.x, at.y, distance + self._trust.band)
        dx, dy = walls[:, 0] - at.x, walls[:, 1] - at.y
        c, s = cos(at.yaw), sin(at.yaw)
        along, across = c * dx + s * dy, np.abs(c * dy - s * dx)
        (around,) = ((along > 0.0) & (across <= along * _AROUND)).nonzero()
        inside = across.take(around) <= along.take(around) * tan(ping.ranger.half_angle)
        if not inside.any():
            return False
        away = np.hypot(dx.take(around), dy.take(around))
        nearest = int(away.argmin())
        if inside[nearest] and distance <= self._trust.farthest:
            x, y = walls[around[nearest]].tolist()
            self._learn(at, (x, y), distance)
        return bool((np.abs(away[inside] - distance) <= self._trust.band).any())

    def walls(self, robot: Pose, reach: float) -> Points:
        """The known walls around the robot, both in the odom frame."""
        at = self.drift.compose(robot)
        return placed(self.plan.near(at.x, at.y, reach), self.drift.inverse())

    def _learn(self, at: Pose, wall: tuple[float, float], distance: float) -> None:
        """The robot is where that wall is at that distance from the transducer."""
        x, y = at.x - wall[0], at.y - wall[1]
        expected = hypot(x, y)
        if not expected:
            return
        x, y = x / expected, y / expected
        row = np.array((x, y, y * (at.x - self.pose.x) - x * (at.y - self.pose.y)))
        trust, spread = self._trust, self._covariance @ row
        total = float(row @ spread) + (trust.echo + trust.echo_part * distance) ** 2
        fits = (distance - expected) ** 2 <= trust.gate**2 * total
        self._matching += (fits - self._matching) / trust.lately
        if fits:
            gain = spread / total
            self._covariance -= np.outer(gain, spread)
            dx, dy, turn = (gain * (distance - expected)).tolist()
            self._be(Pose(self.pose.x + dx, self.pose.y + dy, wrap_angle(self.pose.yaw + turn)))

    def _be(self, pose: Pose) -> None:
        self.pose, self.drift = pose, pose.compose(self._odometry.inverse())
