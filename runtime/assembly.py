"""From a configuration to the parts of a run: one place where they are put together."""

from collections.abc import Iterator, Mapping
from typing import Any

from echogrid.drivers import registry
from echogrid.drivers.device import Device, Line
from echogrid.drivers.errors import UnknownDriverError
from echogrid.drivers.role import RangerRole, Slot, WheelRole
from echogrid.drivers.sound import speed_of_sound
from echogrid.mapping.bayes import BayesGrid
from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.long_term_map import LongTermMap
from echogrid.mapping.mapper import Mapper
from echogrid.mapping.odometry import DifferentialDrive
from echogrid.mapping.pose import Pose
from echogrid.mapping.pose_buffer import PoseBuffer
from echogrid.mapping.virtual_sensor import Sight, VirtualSensor
from echogrid.runtime.config import Config, SensorConfig, WheelConfig
from echogrid.runtime.errors import ConfigError, UsageError
from echogrid.runtime.fusion import Fusion
from echogrid.runtime.toml_lines import Place
from echogrid.runtime.toml_values import Problem, structured

MAP_LIMIT = 4.6
"""nats: the long-term map stays within probabilities of 0.01 and 0.99."""
MOST_CELLS = 4e7
"""A map of 120 MB."""
SECOND_NS = 1_000_000_000


def parts(config: Config) -> tuple[list[Line[Any, Any]], Fusion]:
    """The devices of each bus, and the tick's state. Raises ConfigError with all that a run lacks."""
    found: list[Problem] = []
    for part in (lines, geometry, drive):
        try:
            part(config)
        except ConfigError as error:
            found += error.found
    if found:
        raise ConfigError(found)
    return lines(config), fusion(config)


def fusion(config: Config) -> Fusion:
    """The tick's state. Raises ConfigError when the configuration lacks what a run needs."""
    cells = round(config.local.size_m / config.local.resolution_m)
    local = LocalGrid(
        config.local.resolution_m, cells, config.map.tolerance_m, config.local.fade_s, config.map.no_echo
    )
    sight = Sight(
        sectors=config.obstacle.sectors,
        horizon=config.obstacle.horizon_m,
        stale_ns=round(config.obstacle.stale_s * SECOND_NS),
        stop_distance=config.obstacle.stop_distance_m,
    )
    sensor = VirtualSensor(sight, config.local.resolution_m, cells)
    poses = PoseBuffer(widest_gap_ns=pose_gap_ns(config))
    return Fusion(mapper(config, geometry(config), poses), local, drive(config), sensor)


def mapper(config: Config, area: GridGeometry, poses: PoseBuffer, most_waiting: int | None = 4096) -> Mapper:
    """The long-term map over an area, and what feeds it."""
    long_term = LongTermMap(
        area,
        config.map.tolerance_m,
        lambda grid: BayesGrid(grid, MAP_LIMIT, config.map.model, config.map.no_echo),
    )
    return Mapper((sensor.ranger() for sensor in config.sensor), poses, long_term, most_waiting)


def geometry(config: Config) -> GridGeometry:
    """The configured map area, its middle at the start of the run. Raises ConfigError without its size."""
    width, height = config.map.width_m, config.map.height_m
    if width is None or height is None:
        raise ConfigError([(("map",), "a run needs `width_m` and `height_m`")])
    return centred(Pose(), width, height, config.map.resolution_m)


def centred(middle: Pose, width: float, height: float, resolution: float) -> GridGeometry:
    """An area (m) around a point. Raises UsageError when it has more cells than a map may have."""
    west, south = middle.x - width / 2.0, middle.y - height / 2.0
    return bounded(west, south, west + width, south + height, resolution)


def bounded(west: float, south: float, east: float, north: float, resolution: float) -> GridGeometry:
    """A map over a box (m). Raises UsageError when it has more cells than a map may have."""
    cells = (east - west) / resolution * ((north - south) / resolution)
    if not cells <= MOST_CELLS:
        size = f"{east - west:.6g} m x {north - south:.6g} m at {resolution} m"
        mend = "give [map] `width_m` and `height_m`, or a coarser resolution"
        raise UsageError([f"a map of {size} has {cells:.2g} cells, more than {MOST_CELLS:.0e}: {mend}"])
    return GridGeometry.covering(west, south, east, north, resolution)


def pose_gap_ns(config: Config) -> int:
    """The widest gap between poses that is interpolated."""
    return round(config.map.pose_gap_s * SECOND_NS)


def drive(config: Config) -> DifferentialDrive:
    """Dead reckoning. Raises ConfigError without the wheels' measures."""
    robot = config.robot
    if robot.wheel_radius_m is None or robot.track_m is None:
        raise ConfigError([(("robot",), "`wheel_radius_m` and `track_m` are needed for wheel odometry")])
    return DifferentialDrive(robot.wheel_radius_m, robot.track_m)


def lines(config: Config) -> list[Line[Any, Any]]:
    """The devices of each bus. Raises ConfigError with every driver or setting that is wrong."""
    problems: list[Problem] = []
    devices: dict[str, list[Device[Any, Any]]] = {bus.name: [] for bus in config.bus}
    kinds = {bus.name: bus.kind for bus in config.bus}
    slots = firing_slots(config)
    speed = speed_of_sound(config.robot.air_temperature_c)
    for index, sensor in enumerate(config.sensor):
        role = RangerRole(sensor.name, sensor.min_m, sensor.max_m, slots.get(sensor.name), speed)
        _attach(devices, kinds, sensor, role, ("sensor", index), problems)
    for index, wheel in enumerate(config.wheel):
        wheel_role = WheelRole(wheel.name, wheel.gear, wheel.fastest_rad_s)
        _attach(devices, kinds, wheel, wheel_role, ("wheel", index), problems)
    problems += _doubles(config)
    if {wheel.name for wheel in config.wheel} != {"left", "right"}:
        problems.append(((), "a run needs a [[wheel]] named `left` and one named `right`"))
    if problems:
        raise ConfigError(problems)
    return [Line(name, attached) for name, attached in devices.items() if attached]


def _attach(
    devices: Mapping[str, list[Device[Any, Any]]],
    kinds: Mapping[str, str],
    entry: SensorConfig | WheelConfig,
    role: RangerRole | WheelRole,
    place: Place,
    problems: list[Problem],
) -> None:
    """Make the entry's device and hang it on its bus, or say what is wrong."""
    if entry.driver is None or entry.bus is None:
        problems.append((place, f"{entry.name}: `driver` and `bus` are needed to run"))
        return
    try:
        driver = registry.driver(entry.driver)
    except UnknownDriverError as error:
        problems.append(((*place, "driver"), str(error)))
        return
    if driver.bus != kinds[entry.bus]:
        speaks = f"{entry.driver} speaks {driver.bus}, but bus {entry.bus!r} is {kinds[entry.bus]}"
        problems.append(((*place, "bus"), speaks))
    settings, wrong = structured(dict(entry.settings), driver.Settings)
    problems += [((*place, *key), what) for key, what in wrong]
    try:
        if not wrong:
            devices[entry.bus].append(driver(role, settings))
    except ValueError as error:
        problems.append((place, str(error)))


def _doubles(config: Config) -> Iterator[Problem]:
    """Devices that would answer for each other: two of one address on a bus, two on one serial line."""
    owners: dict[tuple[str, str, object], str] = {}
    entries: list[tuple[str, int, SensorConfig | WheelConfig]] = [
        *(("sensor", index, sensor) for index, sensor in enumerate(config.sensor)),
        *(("wheel", index, wheel) for index, wheel in enumerate(config.wheel)),
    ]
    for kind, index, entry in entries:
        found = _identity(entry)
        if found is None or entry.bus is None:
            continue
        key, value = found
        other = owners.setdefault((entry.bus, key, value), entry.name)
        if other != entry.name:
            same = f"{key} {value}" if key else "the serial line"
            yield (kind, index, key or "bus"), f"{entry.name} and {other} share {same} of bus {entry.bus!r}"


def _identity(entry: SensorConfig | WheelConfig) -> tuple[str, object] | None:
    """What tells a device from the others on its bus; None if its driver or settings are wrong anyway."""
    try:
        driver = registry.driver(entry.driver or "")
    except UnknownDriverError:
        return None
    settings, wrong = structured(dict(entry.settings), driver.Settings)
    if wrong:
        return None
    return driver.identity, getattr(settings, driver.identity) if driver.identity else None


def firing_slots(config: Config) -> dict[str, Slot]:
    """When each ranger of a firing group fires; without groups, all fire one by one."""
    groups = config.firing.groups or tuple((sensor.name,) for sensor in config.sensor)
    gap_ns = round(config.firing.gap_ms * 1e6)
    period_ns = gap_ns * len(groups)
    return {name: Slot(period_ns, turn * gap_ns) for turn, group in enumerate(groups) for name in group}
