"""A robot on two driven wheels. It does what it is told, late and within limits, until it meets something.

It does not pass through what it meets, nor push it: a step into something is not made, and its wheels stand.
People walk on, into the robot too; it may not go nearer to them then.
"""

from bisect import bisect_left
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from math import cos, floor, inf, sin, sqrt
from typing import NamedTuple

import numpy as np

from echogrid.emulation.body import Body, Gaps
from echogrid.emulation.reflectors import Pose
from echogrid.emulation.vista import Post
from echogrid.emulation.walker import WALKING_SPEED
from echogrid.emulation.world import World

STEP_NS = 5_000_000
_STEP_S = STEP_NS * 1e-9
_APART = 0.02
"""m: whoever is so far from all things again touches nothing any more."""
_EASING = 1e-9
"""m: a step that does not come nearer, but for rounding."""
_SLACK = 1.1
"""By so much people may be quicker than they usually are."""


@dataclass(frozen=True, slots=True)
class Drive:
    """What the motors can do."""

    speed: float = 0.78
    """m/s."""
    acceleration: float = 0.8
    """m/s^2, and to slow down."""
    turn_rate: float = 1.57
    """rad/s."""
    turn_acceleration: float = 3.0
    """rad/s^2."""
    latency_ns: int = 50_000_000
    """From a command to the motors."""
    track: float = 0.32
    """m, between the wheels."""
    wheel_radius: float = 0.06
    """m."""

    def stopping_distance(self, speed: float) -> float:
        """m, from the command to the rest: v t + v^2 / 2a."""
        return speed * self.latency_ns * 1e-9 + speed * speed / (2.0 * self.acceleration)


@dataclass(frozen=True, slots=True)
class Touched:
    """What it is that the robot meets."""

    kind: str
    """"wall", "post" or "person"."""
    number: int
    """Among its kind, as the world has them."""


@dataclass(frozen=True, slots=True)
class Contact:
    """The robot begins to touch something."""

    stamp_ns: int
    touched: Touched
    speed: float
    """m/s of the robot's outline just before."""
    travelled: float
    """m up to there."""


class _Command(NamedTuple):
    due_ns: int
    speed: float
    turn_rate: float


@dataclass(slots=True)
class Plant:
    """Goes on in steps of 5 ms from time 0, at which it stands."""

    world: World
    body: Body
    drive: Drive
    start: Pose
    """Map frame; yaw is unwrapped from there on."""
    people_at: Callable[[int], tuple[Post, ...]]
    """Who is where at a time, ns."""
    now_ns: int = 0
    speed: float = 0.0
    turn_rate: float = 0.0
    travelled: float = 0.0
    """m."""
    wheels: tuple[float, float] = (0.0, 0.0)
    """rad, left and right, as they truly turned."""
    contacts: list[Contact] = field(default_factory=list)
    _asked: tuple[float, float] = (0.0, 0.0)
    _commands: deque[_Command] = field(default_factory=deque)
    _poses: list[Pose] = field(default_factory=list)
    _ways: list[float] = field(default_factory=list)
    _touching: bool = False
    _room: float = 0.0
    """m that the robot and people may surely go before anything can be touched."""

    def __post_init__(self) -> None:
        self._poses.append(self.start)
        self._ways.append(0.0)

    @property
    def pose(self) -> Pose:
        """Where it is."""
        return self._poses[-1]

    def pose_at(self, at_ns: int) -> Pose:
        """Where it was; before the start where it starts, and of what is to come where it is."""
        share = at_ns / STEP_NS
        index = floor(share)
        if index < 0:
            return self.start
        if index >= len(self._poses) - 1:
            return self._poses[-1]
        (x, y, yaw), (to_x, to_y, to_yaw) = self._poses[index], self._poses[index + 1]
        share -= index
        return x + share * (to_x - x), y + share * (to_y - y), yaw + share * (to_yaw - yaw)

    def when_travelled(self, way: float) -> int:
        """ns: when it had gone so many metres."""
        return bisect_left(self._ways, way) * STEP_NS

    def ask(self, speed: float, turn_rate: float) -> None:
        """Ask for a twist, m/s and rad/s; it counts when it gets to the motors, until the next does."""
        limits = self.drive
        speed = min(max(speed, -limits.speed), limits.speed)
        turn_rate = min(max(turn_rate, -limits.turn_rate), limits.turn_rate)
        self._commands.append(_Command(self.now_ns + limits.latency_ns, speed, turn_rate))

    def gaps(self) -> Gaps:
        """How far everything is from it now."""
        return self.body.gaps(self.pose, self.world, self.people_at(self.now_ns))

    def step(self) -> None:
        """Go on by a step."""
        while self._commands and self._commands[0].due_ns <= self.now_ns:
            _, *asked = self._commands.popleft()
            self._asked = asked[0], asked[1]
        limits = self.drive
        self.speed = _led(self.speed, self._asked[0], limits.acceleration * _STEP_S)
        self.turn_rate = _led(self.turn_rate, self._asked[1], limits.turn_acceleration * _STEP_S)
        self.now_ns += STEP_NS
        pose = self._led_on()
        reach = self.body.reach
        self._room -= (abs(self.speed) + reach * abs(self.turn_rate)) * _STEP_S
        if self.world.walkers:
            self._room -= _SLACK * WALKING_SPEED * _STEP_S
        if self._room > 0.0 or self._may_go(pose):
            self._go(pose)
        else:
            self.speed = self.turn_rate = 0.0
            self._poses.append(self._poses[-1])
        self._ways.append(self.travelled)

    def _led_on(self) -> Pose:
        x, y, yaw = self._poses[-1]
        way, turn = self.speed * _STEP_S, self.turn_rate * _STEP_S
        heading = yaw + 0.5 * turn
        return x + way * cos(heading), y + way * sin(heading), yaw + turn

    def _go(self, pose: Pose) -> None:
        way, lead = self.speed * _STEP_S, 0.5 * self.drive.track * self.turn_rate * _STEP_S
        radius = self.drive.wheel_radius
        self.wheels = self.wheels[0] + (way - lead) / radius, self.wheels[1] + (way + lead) / radius
        self.travelled += abs(way)
        self._poses.append(pose)

    def _may_go(self, pose: Pose) -> bool:
        """Whether the step leads into nothing that stands, and no nearer to people whom it touches; a new
        contact is noted."""
        people = self.people_at(self.now_ns)
        after = self.body.gaps(pose, self.world, people)
        self._room = after.least
        if self._room > 0.0:
            self._touching = self._touching and self._room <= _APART
            return True
        if not self._touching:
            self._touching = True
            speed = self.body.speed(self.speed, self.turn_rate)
            self.contacts.append(Contact(self.now_ns, self._nearest(after), speed, self.travelled))
        standing = len(self.world.cylinders)
        if (after.walls <= 0.0).any() or (after.posts[:standing] <= 0.0).any():
            return False
        before = self.body.gaps(self._poses[-1], self.world, people)
        nearer = (after.posts <= 0.0) & (after.posts < before.posts - _EASING)
        return not nearer.any()

    def _nearest(self, gaps: Gaps) -> Touched:
        """What is touched, or overlapped the most."""
        wall, post = gaps.walls.min(initial=inf), gaps.posts.min(initial=inf)
        if wall < post:
            return Touched("wall", int(gaps.walls.argmin()))
        number, standing = int(gaps.posts.argmin()), len(self.world.cylinders)
        return Touched("post", number) if number < standing else Touched("person", number - standing)


def _led(value: float, wanted: float, most: float) -> float:
    return value + min(max(wanted - value, -most), most)


@dataclass(slots=True)
class Encoders:
    """What is measured of the wheels: radii a little off, and slip that adds up as a random walk.

    By default as after a calibration by UMBmark: much of the scale, little of the difference is left.
    """

    seed: int
    scale_error: float = 0.005
    """Standard deviation of both wheels' radius, in proportion;"""
    difference: float = 0.0005
    """and of each on its own."""
    slip: float = 0.0015
    """m, standard deviation after 1 m of each wheel's way; it grows with the root of the way."""
    wheel_radius: float = 0.06
    _measured: tuple[float, float] = (0.0, 0.0)
    _true: tuple[float, float] = (0.0, 0.0)
    _scales: tuple[float, float] = field(init=False)
    _rng: np.random.Generator = field(init=False)

    def __post_init__(self) -> None:
        self._rng = np.random.default_rng((self.seed, 77))
        both, left, right = self._rng.standard_normal(3).tolist()
        scale = 1.0 + self.scale_error * both
        self._scales = scale + self.difference * left, scale + self.difference * right

    def read(self, wheels: tuple[float, float]) -> tuple[float, float]:
        """rad, from how far the wheels truly turned."""
        noises = self._rng.standard_normal(2).tolist()
        self._measured = (
            self._measured[0] + self._turned(0, wheels, noises[0]),
            self._measured[1] + self._turned(1, wheels, noises[1]),
        )
        self._true = wheels
        return self._measured

    def _turned(self, side: int, wheels: tuple[float, float], noise: float) -> float:
        turned = wheels[side] - self._true[side]
        way = abs(turned) * self.wheel_radius
        return turned * self._scales[side] + noise * self.slip * sqrt(way) / self.wheel_radius
