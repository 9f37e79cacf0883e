"""What the wheels' angles say of the robot's motion, and how sure they are of it.

A wheel's way has a variance that grows with the distance it rolled (Chong & Kleeman 1997). `spread` is that
variance for a way of 1 m, in m^2 per m. Each kind of drive carries it through its own Jacobian to the robot's
way ahead and turn.
"""

from dataclasses import dataclass, replace
from math import cos, sin, tan
from typing import ClassVar, NamedTuple, Protocol


@dataclass(frozen=True, slots=True)
class Motion:
    """How base_link moved between two looks: a way ahead and a turn, at even rates."""

    forward: float
    """m."""
    turn: float
    """rad, counter-clockwise."""
    forward_variance: float = 0.0
    turn_variance: float = 0.0
    shared: float = 0.0
    """The covariance of both, m rad."""

    def less_sure(self, factor: float) -> "Motion":
        """The same with its variances that many times as large."""
        return replace(
            self,
            forward_variance=self.forward_variance * factor,
            turn_variance=self.turn_variance * factor,
            shared=self.shared * factor,
        )


Angles = tuple[float, float]
"""Of the two encoders that a drive has, absolute and unwrapped, rad."""


class Wheels(NamedTuple):
    """What the two encoders of a drive are called."""

    first: str
    second: str
    steered: bool
    """The second tells an angle of steering, and the first the only way."""


class Kinematics(Protocol):
    """A kind of drive."""

    wheels: ClassVar[Wheels]

    def motion(self, before: Angles, after: Angles) -> Motion:
        """The motion between the encoders' angles."""
        ...


@dataclass(frozen=True, slots=True)
class Differential:
    """A driven wheel on either side; the angles are those of the left and the right wheel.

    base_link is in the middle between them.
    """

    wheels: ClassVar[Wheels] = Wheels("left", "right", steered=False)

    left_radius: float
    right_radius: float
    track: float
    """m, between the points where the wheels touch the floor."""
    spread: float

    def motion(self, before: Angles, after: Angles) -> Motion:
        """forward = (right + left) / 2, turn = (right - left) / track."""
        left = (after[0] - before[0]) * self.left_radius
        right = (after[1] - before[1]) * self.right_radius
        of_left, of_right = self.spread * abs(left), self.spread * abs(right)
        return Motion(
            (right + left) / 2.0,
            (right - left) / self.track,
            (of_right + of_left) / 4.0,
            (of_right + of_left) / self.track**2,
            (of_right - of_left) / (2.0 * self.track),
        )

    def rates(self, speed: float, turn_rate: float) -> tuple[float, float]:
        """The rates (rad/s) of the left and the right wheel for a speed (m/s) and a turn rate (rad/s)."""
        lead = turn_rate * self.track / 2.0
        return (speed - lead) / self.left_radius, (speed + lead) / self.right_radius


def skid_steer(drive: Differential, slip_factor: float) -> Differential:
    """The differential drive that moves as this one does when its wheels must slide sideways to turn.

    Its wheels seem to stand further apart: the effective track is `slip_factor` times the measured one
    (1 to 2 or so, found by calibration; Mandow et al., IROS 2007).
    """
    return replace(drive, track=drive.track * slip_factor)


@dataclass(frozen=True, slots=True)
class _Steered:
    """A driven wheel, whose angle is the first, and an angle of steering, which is the second.

    base_link is in the middle of the axle that is not steered. The steering angle is absolute: 0 is straight
    ahead, positive steers to the left. Its variance over a way is `steering_spread` (rad^2 m) by that way, so
    that it does not matter into how many steps a way is cut.
    """

    wheels: ClassVar[Wheels] = Wheels("drive", "steering", steered=True)

    radius: float
    wheelbase: float
    """m, from the axle that is not steered to the steered wheel."""
    spread: float
    steering_spread: float

    def _rolled(self, before: Angles, after: Angles) -> tuple[float, float]:
        """The driven wheel's way (m), and the mean steering angle."""
        return (after[0] - before[0]) * self.radius, (before[1] + after[1]) / 2.0


@dataclass(frozen=True, slots=True)
class Tricycle(_Steered):
    """One wheel is both driven and steered, before the axle of two that roll freely."""

    def motion(self, before: Angles, after: Angles) -> Motion:
        """forward = way cos(steering), turn = way sin(steering) / wheelbase."""
        way, steering = self._rolled(before, after)
        c, s = cos(steering), sin(steering)
        of_way, of_steering = self.spread * abs(way), self.steering_spread * abs(way)
        return Motion(
            way * c,
            way * s / self.wheelbase,
            of_way * c**2 + of_steering * s**2,
            (of_way * s**2 + of_steering * c**2) / self.wheelbase**2,
            (of_way - of_steering) * s * c / self.wheelbase,
        )


@dataclass(frozen=True, slots=True)
class Ackermann(_Steered):
    """The axle at base_link is driven, through a differential; the wheels before it are steered.

    The steering angle is that of a wheel in the middle between them (the bicycle model).
    """

    def motion(self, before: Angles, after: Angles) -> Motion:
        """forward = way, turn = way tan(steering) / wheelbase."""
        way, steering = self._rolled(before, after)
        t = tan(steering)
        of_way, of_steering = self.spread * abs(way), self.steering_spread * abs(way)
        return Motion(
            way,
            way * t / self.wheelbase,
            of_way,
            (of_way * t**2 + of_steering * (1.0 + t**2) ** 2) / self.wheelbase**2,
            of_way * t / self.wheelbase,
        )
