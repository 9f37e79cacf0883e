"""One mounted ranger in a world: when it fires, what does it hear?"""

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, sin
from zlib import crc32

import numpy as np

from echogrid.emulation.acoustics import Transducer, speed_of_sound
from echogrid.emulation.reflections import Listener
from echogrid.emulation.reflectors import Pose
from echogrid.emulation.scene import Echo, Scene
from echogrid.emulation.world import World

PoseAt = Callable[[int], Pose]
"""Time, ns -> pose of the robot: x, y (m), yaw (rad), map frame."""


@dataclass(frozen=True, slots=True)
class Ranger:
    """A transducer with its place on the robot."""

    name: str
    mount: Pose
    """x, y (m), yaw (rad) in base_link."""
    transducer: Transducer


def scene_of(world: World, pose_at: PoseAt, ranger: Ranger, seed: int | None) -> Scene:
    """The scene of one ranger; the same seed and pings give the same echoes. Without a seed: no noise.

    A moving robot hears from where it is when the sound meets the first obstacle.
    """
    rng = None if seed is None else np.random.default_rng((seed, crc32(ranger.name.encode())))
    listener = Listener(world, ranger.transducer, rng)
    speed = speed_of_sound(world.temperature)

    def scene(fire_ns: int) -> tuple[Echo, ...]:
        def after(way: float) -> Pose:
            return mounted(pose_at(fire_ns + round(1e9 * way / speed)), ranger.mount)

        sensor = after(0.0)
        moves = after(ranger.transducer.reach) != sensor
        return listener.hear(sensor, after if moves else None)

    return scene


def mounted(pose: Pose, mount: Pose) -> Pose:
    """Pose in the map frame of something mounted on the robot."""
    x, y, yaw = pose
    ahead, aside, turn = mount
    return x + ahead * cos(yaw) - aside * sin(yaw), y + ahead * sin(yaw) + aside * cos(yaw), yaw + turn
