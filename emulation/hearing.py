"""One mounted ranger in a world: when it fires, what does it hear?"""

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, inf, sin
from zlib import crc32

import numpy as np

from echogrid.emulation.acoustics import Transducer, speed_of_sound
from echogrid.emulation.reflections import Pose, echoes, first_contact
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
    transducer = ranger.transducer
    speed = speed_of_sound(world.temperature)

    def scene(fire_ns: int) -> tuple[Echo, ...]:
        sensor = mounted(pose_at(fire_ns), ranger.mount)
        if mounted(pose_at(fire_ns + round(1e9 * transducer.reach / speed)), ranger.mount) != sensor:
            contact = first_contact(world, sensor, transducer)
            outward_ns = round(1e9 * contact / speed) if contact < inf else 0
            sensor = mounted(pose_at(fire_ns + outward_ns), ranger.mount)
        return echoes(world, sensor, transducer, rng)

    return scene


def mounted(pose: Pose, mount: Pose) -> Pose:
    """Pose in the map frame of something mounted on the robot."""
    x, y, yaw = pose
    ahead, aside, turn = mount
    return x + ahead * cos(yaw) - aside * sin(yaw), y + ahead * sin(yaw) + aside * cos(yaw), yaw + turn
