"""The robots that are tried: their outline, their motors, and which ranger fires when."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from math import cos, pi, radians, sin

from echogrid.emulation import hearing
from echogrid.emulation.acoustics import Transducer
from echogrid.emulation.body import Body, Disc
from echogrid.emulation.plant import Drive
from echogrid.emulation.transducers import POLAROID, TRANSDUCERS
from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.sonar_model import NoEcho
from echogrid.runtime.config import Config, LocalConfig
from echogrid.runtime.emulated import DEFAULT_ROBOT
from echogrid.runtime.firing_groups import grouped
from echogrid.runtime.robot_file import load

_MILLISECOND_NS = 1_000_000
_GAP_NS = 35 * _MILLISECOND_NS
"""Of a ring: from one group to the next; 4 m and back, and 12 ms in which it dies away."""
_REACH_M = 4.0
_NEAREST_M = 0.15
_SENSORS_AT_M = 0.08
"""From the middle: set back, so that their blanking distance ends at the robot's rim."""
_RADIUS_M = 0.22
_SEPARATION = radians(90.0)
_BUILT_IN_RADIUS_M = 0.2
_UNASKED_NS = 100 * _MILLISECOND_NS
"""How often an A02YYUW sends."""


@dataclass(frozen=True, slots=True)
class Seat:
    """A ranger on the robot, as the emulator and as the map see it, and when it fires."""

    heard: hearing.Ranger
    ranger: Ranger
    first_ns: int
    every_ns: int
    lag_ns: int = 0
    """From the end of its listening until its reading is there."""


@dataclass(frozen=True, slots=True)
class Rig:
    """A robot."""

    name: str
    body: Body
    seats: tuple[Seat, ...]
    """Counter-clockwise: neighbours are adjacent, the last and the first too."""
    local: LocalConfig
    tolerance: float
    """m: half of the band in which an echo's obstacle lies."""
    drive: Drive = field(default_factory=Drive)

    def local_grid(self) -> LocalGrid:
        """As the robot's service makes it."""
        cells = round(self.local.size_m / self.local.resolution_m)
        return LocalGrid(self.local.resolution_m, cells, self.tolerance, self.local.fade_s, NoEcho.WEAK)


def _ring(count: int) -> Rig:
    """Polaroids of +-15 deg all around; each group of four looks into four directions."""
    bearings = [2.0 * pi * index / count for index in range(count)]
    groups = grouped(bearings, _SEPARATION)
    turns = {index: turn for turn, group in enumerate(groups) for index in group}
    transducer = replace(POLAROID, reach=_REACH_M)

    def seat(index: int, bearing: float) -> Seat:
        mount = Pose(_SENSORS_AT_M * cos(bearing), _SENSORS_AT_M * sin(bearing), bearing)
        ranger = Ranger(f"ring_{index}", mount, radians(15.0), _NEAREST_M, _REACH_M)
        return _seat(ranger, transducer, turns[index] * _GAP_NS, len(groups) * _GAP_NS)

    seats = tuple(seat(index, bearing) for index, bearing in enumerate(bearings))
    return Rig(f"ring-{count}", Disc(_RADIUS_M), seats, LocalConfig(resolution_m=0.1), 0.1)


def _built_in() -> Rig:
    """The robot that `echogrid run` drives; its SRF08 are heard without their chips' gain ramp."""
    config = load(DEFAULT_ROBOT)
    turns = {name: turn for turn, group in enumerate(config.firing.groups) for name in group}
    gap_ns = round((config.firing.gap_ms or 0.0) * _MILLISECOND_NS)
    seats = tuple(_configured(config, index, turns, gap_ns) for index in _around(config))
    return Rig("built-in", Disc(_BUILT_IN_RADIUS_M), seats, config.local, config.map.tolerance_m)


def _around(config: Config) -> list[int]:
    """The sensors' numbers, counter-clockwise."""
    return sorted(range(len(config.sensor)), key=lambda index: config.sensor[index].yaw_deg % 360.0)


def _configured(config: Config, index: int, turns: Mapping[str, int], gap_ns: int) -> Seat:
    sensor = config.sensor[index]
    transducer = TRANSDUCERS[sensor.driver or ""]
    if sensor.name in turns:
        cycle_ns = len(config.firing.groups) * gap_ns
        return _seat(sensor.ranger(), transducer, turns[sensor.name] * gap_ns, cycle_ns)
    lag_ns = round(float(sensor.settings.get("lag_ms", 0.0)) * _MILLISECOND_NS)
    seat = _seat(sensor.ranger(), transducer, index * 7 * _MILLISECOND_NS, _UNASKED_NS)
    return replace(seat, lag_ns=lag_ns)


def _seat(ranger: Ranger, transducer: Transducer, first_ns: int, every_ns: int) -> Seat:
    mount = ranger.mount
    heard = hearing.Ranger(ranger.name, (mount.x, mount.y, mount.yaw), transducer)
    return Seat(heard, ranger, first_ns, every_ns)


RIGS: Mapping[str, Callable[[], Rig]] = {
    "ring-16": lambda: _ring(16),
    "ring-12": lambda: _ring(12),
    "built-in": _built_in,
}
