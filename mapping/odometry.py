"""Dead reckoning: the pose and its covariance, from motions one after the other."""

from dataclasses import dataclass, field, replace
from math import cos, sin

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.gap import GapWatch
from echogrid.mapping.kinematics import Angles, Kinematics, Motion
from echogrid.mapping.pose import Pose, wrap_angle
from echogrid.mapping.yaw_fusion import YawFusion

Covariance = NDArray[np.float64]
"""(3, 3), of x (m), y (m) and yaw (rad)."""

_STRAIGHT = 1e-6
"""rad: a smaller turn is driven straight, where the arc's radius would lose all digits."""
_GAP_DOUBT = 10.0
"""How much larger the variances of a motion are that was seen only from both ends of a gap."""


def midpoint_step(pose: Pose, motion: Motion) -> Pose:
    """The pose after a motion, by the midpoint rule.

    It moves along the mean heading: x += forward cos(yaw + turn/2). Its Jacobians are those of `propagate`.
    """
    heading = pose.yaw + motion.turn / 2.0
    return Pose(
        pose.x + motion.forward * cos(heading),
        pose.y + motion.forward * sin(heading),
        wrap_angle(pose.yaw + motion.turn),
    )


def arc_step(pose: Pose, motion: Motion) -> Pose:
    """The pose after a motion, along the exact circular arc."""
    if abs(motion.turn) <= _STRAIGHT:
        return midpoint_step(pose, motion)
    radius = motion.forward / motion.turn
    yaw = pose.yaw + motion.turn
    return Pose(
        pose.x + radius * (sin(yaw) - sin(pose.yaw)),
        pose.y - radius * (cos(yaw) - cos(pose.yaw)),
        wrap_angle(yaw),
    )


def propagate(covariance: Covariance, pose: Pose, motion: Motion) -> Covariance:
    """The covariance after a motion from `pose`.

    P' = F P F' + G M G', where F and G are the midpoint step's Jacobians by the pose and by the motion, and M
    is the motion's own covariance. As M was carried through the drive's Jacobian, G M G' is the V Q V' of
    Chong & Kleeman 1997.
    """
    heading = pose.yaw + motion.turn / 2.0
    c, s = cos(heading), sin(heading)
    aside, ahead = -motion.forward * s, motion.forward * c
    (xx, xy, xt), (_, yy, yt), (_, _, tt) = covariance.tolist()
    # Term by term: matrices of three are no quicker than their numbers.
    f, h, t = motion.forward_variance, motion.shared, motion.turn_variance
    u, v = c * f + 0.5 * aside * h, c * h + 0.5 * aside * t
    w, z = s * f + 0.5 * ahead * h, s * h + 0.5 * ahead * t
    xx += aside * (2.0 * xt + aside * tt) + u * c + 0.5 * v * aside
    xy += aside * yt + ahead * (xt + aside * tt) + u * s + 0.5 * v * ahead
    yy += ahead * (2.0 * yt + ahead * tt) + w * s + 0.5 * z * ahead
    xt += aside * tt + v
    yt += ahead * tt + z
    tt += t
    return np.array([[xx, xy, xt], [xy, yy, yt], [xt, yt, tt]])


def _sure() -> Covariance:
    return np.zeros((3, 3))


@dataclass(slots=True)
class Odometry:
    """The pose in the odom frame, from where the encoders were first seen, and how sure it is.

    After a gap a motion counts as less sure. After a restart, when what was driven meanwhile is lost, the
    robot may have gone on as before: the way and the turn that it would have made become standard deviations.
    """

    kinematics: Kinematics
    yaw_fusion: YawFusion | None = None
    """Where there is a gyro."""
    pose: Pose = field(default_factory=Pose)
    covariance: Covariance = field(default_factory=_sure)
    """Of the pose. A new array at each step: it may be kept."""
    travelled: float = 0.0
    """m, the length of the path."""
    _last: tuple[int, Angles] | None = None
    _speed: tuple[float, float] = (0.0, 0.0)
    _gaps: GapWatch = field(default_factory=GapWatch)

    def update(self, stamp_ns: int, angles: Angles, restarted: bool = False) -> Pose:
        """The pose now that the encoders stand at these absolute angles; stamps rise from call to call.

        `restarted`: they were led on with zero motion since the last call.
        """
        if self._last is not None:
            last_ns, before = self._last
            self._move(last_ns, stamp_ns, self.kinematics.motion(before, angles), restarted)
        self._last = stamp_ns, angles
        return self.pose

    def _move(self, start_ns: int, end_ns: int, motion: Motion, restarted: bool) -> None:
        interval_ns = end_ns - start_ns
        if self._gaps.is_gap(interval_ns):
            motion = motion.less_sure(_GAP_DOUBT)
        if self.yaw_fusion is not None:
            motion = self.yaw_fusion.fused(start_ns, end_ns, motion)
        if restarted:
            motion = self._doubted(motion, interval_ns)
        self.covariance = propagate(self.covariance, self.pose, motion)
        self.pose = arc_step(self.pose, motion)
        self.travelled += abs(motion.forward)
        self._speed = motion.forward / interval_ns, motion.turn / interval_ns

    def _doubted(self, motion: Motion, interval_ns: int) -> Motion:
        """The motion, with what it may have been. The pose is also that of a log which tells no restarts."""
        forward, turn = (speed * interval_ns for speed in self._speed)
        return replace(
            motion,
            forward_variance=motion.forward_variance + forward**2,
            turn_variance=motion.turn_variance + turn**2,
        )
