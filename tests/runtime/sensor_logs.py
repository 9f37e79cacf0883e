"""Logs of a small robot that drives about in one room, by the emulated acoustics, poses exactly known."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from math import radians

import numpy as np

from echogrid.drivers.readings import RangeReading, classify
from echogrid.emulation.acoustics import speed_of_sound
from echogrid.emulation.hearing import Outing, Ranger, scene_of
from echogrid.emulation.motion import Tour
from echogrid.emulation.transducers import A02YYUW
from echogrid.emulation.truth import truth
from echogrid.emulation.world import World
from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.pose import Pose
from echogrid.runtime.config import Config, MapConfig
from echogrid.runtime.hardware_config import SensorConfig
from echogrid.runtime.loop import SECOND_NS
from echogrid.runtime.recording import Recording
from echogrid.runtime.reference_map import Reference, faces_of_world, known
from echogrid.runtime.truth_map import TruthMap

MODEL = A02YYUW
WALLS = (
    (0.0, 0.0, 5.0, 0.0),
    (5.0, 0.0, 5.0, 3.0),
    (5.0, 3.0, 4.0, 4.0),  # a slant
    (4.0, 4.0, 0.0, 4.0),
    (0.0, 4.0, 0.0, 0.0),
    (2.2, 1.7, 3.0, 1.7),  # a cabinet in the middle
    (3.0, 1.7, 3.0, 2.3),
    (3.0, 2.3, 2.2, 2.3),
    (2.2, 2.3, 2.2, 1.7),
)
ROOM = World("room", np.array(WALLS), np.zeros(len(WALLS), np.bool_), np.zeros((0, 3)))
CORNERS = ((1.0, 1.0), (2.6, 0.8), (4.0, 1.1), (3.9, 2.9), (2.5, 3.2), (1.1, 2.8))
TOUR = Tour(CORNERS, frozenset(range(len(CORNERS))))
NAMES = ("front", "left", "rear", "right")
GAP_NS = 35_000_000


@dataclass(frozen=True)
class Trick:
    """What is wrong with a log."""

    yaw_deg: Mapping[str, float] = field(default_factory=dict)
    """By what robot.toml's mounting angles are more than the true ones."""
    bias: Mapping[str, float] = field(default_factory=dict)
    """m: by what the readings are more than the true ones."""


RIGHT = Trick()


@cache
def heard(seconds: float, seed: int = 1) -> tuple[tuple[int, int, float], ...]:
    """The time, ranger and distance (m; inf: nothing) of every ping of a true robot."""
    outing = Outing(ROOM, lambda now_ns: TOUR.pose(now_ns / SECOND_NS), seed)
    mounts = [(sensor.x_m, sensor.y_m, radians(sensor.yaw_deg)) for sensor in sensors()]
    scenes = [scene_of(outing, Ranger(name, mount, MODEL)) for name, mount in zip(NAMES, mounts, strict=True)]
    found = []
    for number in range(int(seconds * SECOND_NS) // GAP_NS):
        fired_ns, index = SECOND_NS + number * GAP_NS, number % len(NAMES)
        echoes = scenes[index](fired_ns)
        distance = echoes[0].distance if echoes else float("inf")
        way = min(distance, 3.0) / speed_of_sound(ROOM.temperature)
        found.append((fired_ns + round(way * SECOND_NS), index, distance))
    return tuple(found)


def sensors(half_angle_deg: float = 15.0) -> tuple[SensorConfig, ...]:
    places = ((0.1, 0.0, 0.0), (0.0, 0.1, 90.0), (-0.1, 0.0, 180.0), (0.0, -0.1, -90.0))
    return tuple(
        SensorConfig(name, *place, half_angle_deg, 0.05, 3.0)
        for name, place in zip(NAMES, places, strict=True)
    )


def log(seconds: float, trick: Trick = RIGHT, half_angle_deg: float = 15.0) -> Recording:
    """A recording, as the robot's own robot.toml understands it."""
    config = Config(
        sensor=tuple(
            replace(sensor, yaw_deg=sensor.yaw_deg + trick.yaw_deg.get(sensor.name, 0.0))
            for sensor in sensors(half_angle_deg)
        ),
        map=MapConfig(resolution_m=0.1),
    )
    times = range(0, int((seconds + 2.0) * SECOND_NS), 20_000_000)
    poses = [(now_ns, Pose(*TOUR.pose(now_ns / SECOND_NS))) for now_ns in times]
    ranges = []
    for place, (stamp_ns, index, distance) in enumerate(heard(seconds)):
        told = distance + trick.bias.get(NAMES[index], 0.0)
        outcome, metres = classify(told, 0.05, 3.0)
        reading = RangeReading(stamp_ns, 0, NAMES[index], outcome, metres)
        ranges.append((f"log:{place}", reading))
    return Recording(config, poses, ranges)


def room() -> Reference:
    """The room as it is."""
    area = GridGeometry.covering(-1.0, -1.0, 6.0, 5.0, 0.1)
    return known(
        TruthMap(area, *truth(ROOM, area.x_centres, area.y_centres, CORNERS[0])), faces_of_world(ROOM)
    )
