"""One mounted ranger in a world: when it fires, what does it hear of its own ping?"""

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, sin
from zlib import crc32

import numpy as np

from echogrid.emulation.acoustics import Transducer, speed_of_sound
from echogrid.emulation.reflections import Listener
from echogrid.emulation.reflectors import Pose
from echogrid.emulation.scene import Echo, Scene
from echogrid.emulation.world import Moment, World

PoseAt = Callable[[int], Pose]
"""Time, ns -> pose of the robot: x, y (m), yaw (rad), map frame."""


@dataclass(frozen=True, slots=True)
class Ranger:
    """A transducer with its place on the robot."""

    name: str
    mount: Pose
    """x, y (m), yaw (rad) in base_link."""
    transducer: Transducer


@dataclass(frozen=True, slots=True)
class Outing:
    """A robot on its way through a world."""

    world: World
    pose_at: PoseAt
    seed: int | None
    """Of all noise; None: there is none."""
    started_ns: int = 0
    """When the world's own time begins, by which people walk."""

    def time_s(self, now_ns: int) -> float:
        """The world's own time."""
        return 1e-9 * (now_ns - self.started_ns)

    def moment(self, now_ns: int) -> Moment:
        """The world as it is at a time."""
        return self.world.at(self.time_s(now_ns))

    def pose_of(self, ranger: Ranger, now_ns: int) -> Pose:
        """Where a ranger is at a time, map frame."""
        return mounted(self.pose_at(now_ns), ranger.mount)

    def noise(self, ranger: Ranger, *kind: int) -> np.random.Generator | None:
        """The generator of a ranger's noise of some kind, which no other shares."""
        if self.seed is None:
            return None
        return np.random.default_rng((self.seed, crc32(ranger.name.encode()), *kind))


def scene_of(outing: Outing, ranger: Ranger) -> Scene:
    """The scene of one ranger alone; the same seed and pings give the same echoes.

    A moving robot hears from where it is when the sound meets the first obstacle.
    """
    listener = Listener(outing.world, ranger.transducer, outing.noise(ranger))
    speed = speed_of_sound(outing.world.temperature)

    def scene(fire_ns: int) -> tuple[Echo, ...]:
        def after(way: float) -> Pose:
            return outing.pose_of(ranger, fire_ns + round(1e9 * way / speed))

        sensor = after(0.0)
        moves = after(ranger.transducer.reach) != sensor
        return listener.hear(sensor, after if moves else None, outing.time_s(fire_ns))

    return scene


def mounted(pose: Pose, mount: Pose) -> Pose:
    """Pose in the map frame of something mounted on the robot."""
    x, y, yaw = pose
    ahead, aside, turn = mount
    return x + ahead * cos(yaw) - aside * sin(yaw), y + ahead * sin(yaw) + aside * cos(yaw), yaw + turn
