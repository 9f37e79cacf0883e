"""Poses in the plane: REP-103 axes, x forward, y left, yaw counter-clockwise."""

from dataclasses import dataclass
from math import cos, remainder, sin, tau


def wrap_angle(angle: float) -> float:
    """The same angle in [-pi, pi], free of rounding."""
    return remainder(angle, tau)


@dataclass(frozen=True, slots=True)
class Pose:
    """A position (m) and heading (rad) in some frame."""

    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0

    def compose(self, child: "Pose") -> "Pose":
        """The pose of `child`, which is given relative to this one, in this one's frame."""
        c, s = cos(self.yaw), sin(self.yaw)
        return Pose(
            self.x + c * child.x - s * child.y,
            self.y + s * child.x + c * child.y,
            wrap_angle(self.yaw + child.yaw),
        )

    def inverse(self) -> "Pose":
        """The pose of the parent frame relative to this pose."""
        c, s = cos(self.yaw), sin(self.yaw)
        return Pose(-c * self.x - s * self.y, s * self.x - c * self.y, wrap_angle(-self.yaw))


ORIGIN = Pose()
"""Of a frame in itself."""


def interpolate(start: Pose, end: Pose, fraction: float) -> Pose:
    """The pose a fraction of the way from start to end: straight in x and y, the short way round in yaw."""
    return Pose(
        start.x + fraction * (end.x - start.x),
        start.y + fraction * (end.y - start.y),
        wrap_angle(start.yaw + fraction * wrap_angle(end.yaw - start.yaw)),
    )
