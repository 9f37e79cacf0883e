"""Reading robot.toml: every error at once, with file, line, key and reason."""

import tomllib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import fields, replace
from operator import itemgetter
from pathlib import Path
from typing import Any

from echogrid.runtime import sonar_model_file
from echogrid.runtime.config import Config
from echogrid.runtime.errors import ConfigError, UsageError, described
from echogrid.runtime.hardware_config import GyroConfig, RobotConfig, SensorConfig, WheelConfig
from echogrid.runtime.toml_lines import Place, key_lines
from echogrid.runtime.toml_values import Problem, nearest, structured


def load(path: Path) -> Config:
    """The file's configuration. Raises UsageError with one line for every problem."""
    try:
        text = path.read_text(encoding="utf-8")
        table = tomllib.loads(text)
    except OSError as error:
        raise UsageError(
            [f"{path}: {error.strerror or error} (a robot is described by a robot.toml)"]
        ) from error
    except ValueError as error:
        raise UsageError([f"{path}: not TOML: {error}"]) from error
    except RecursionError as error:
        raise UsageError([f"{path}: nested too deeply"]) from error
    config, problems = _checked(table)
    if config is None or problems:
        raise UsageError(_located(path, text, problems))
    return _with_its_model(path, text, config)


def _with_its_model(path: Path, text: str, config: Config) -> Config:
    """The configuration with the model's file found beside robot.toml, and looked through."""
    name, place = config.map.model_file, ("map", "model_file")
    if name is None:
        return config
    if Path(name).name != name:
        plain = f"`model_file` is the name of a file beside robot.toml, not a path: {name!r}"
        raise UsageError(_located(path, text, [(place, plain)]))
    beside = str(path.resolve().parent / name)
    if config.map.model == "empirical":
        try:
            sonar_model_file.read(Path(beside))
        except UsageError as error:
            raise UsageError(_located(path, text, [(place, what) for what in error.problems])) from error
    return replace(config, map=replace(config.map, model_file=beside))


@contextmanager
def located(path: Path) -> Iterator[None]:
    """Add file and lines to what is found wrong with the configuration from that file."""
    try:
        yield
    except ConfigError as error:
        raise UsageError(_located(path, path.read_text(encoding="utf-8"), error.found)) from error


def _checked(table: dict[str, Any]) -> tuple[Config | None, list[Problem]]:
    config, problems = structured(_with_settings_apart(table), Config)
    if config is not None:
        return config, list(_contradictions(config))
    return None, [(place, what + _for_want_of_driver(table, place)) for place, what in problems]


def _for_want_of_driver(table: dict[str, Any], place: Place) -> str:
    """What to add about a key which may be a driver's, where no driver is named."""
    match place:
        case ("sensor" as kind, int(index), str(key)) if "driver" not in table[kind][index]:
            common = {each.name for each in fields(SensorConfig)}
            return "" if key in common else "; a driver's own keys need `driver`, which is missing"
    return ""


def _with_settings_apart(table: dict[str, Any]) -> dict[str, Any]:
    """Move the keys which are a driver's own into `settings`, where there is a driver."""
    result = dict(table)
    for name, kind in (("sensor", SensorConfig), ("wheel", WheelConfig), ("gyro", GyroConfig)):
        if isinstance(entries := table.get(name), list):
            common = {each.name for each in fields(kind)} - {"settings"}
            result[name] = [_split(entry, common) for entry in entries]
    return result


def _split(entry: Any, common: set[str]) -> Any:
    if not isinstance(entry, dict) or "driver" not in entry:
        return entry
    own = {key: value for key, value in entry.items() if key not in common}
    return {key: value for key, value in entry.items() if key in common} | ({"settings": own} if own else {})


def _contradictions(config: Config) -> Iterator[Problem]:
    """What each table allows by itself but not beside the others."""
    yield from _taken("bus", [bus.name for bus in config.bus])
    yield from _taken("sensor", [sensor.name for sensor in config.sensor])
    yield from _taken("wheel", [wheel.name for wheel in config.wheel])
    yield from _named_alike(config)
    if config.gyro[1:]:
        yield ("gyro", 1), "a second [[gyro]]: one at most is used"
    yield from _ports_taken(config)
    yield from _without_bus("sensor", [sensor.bus for sensor in config.sensor], config)
    yield from _without_bus("wheel", [wheel.bus for wheel in config.wheel], config)
    yield from _without_bus("gyro", [gyro.bus for gyro in config.gyro], config)
    yield from _without_bus("output", [output.bus for output in config.output], config)
    yield from _outputs_amiss(config)
    yield from _misfires(config)
    yield from _of_another_drive(config)
    if not config.sensor:
        yield (), "no [[sensor]]: at least one is needed"


def _taken(kind: str, names: list[str]) -> Iterator[Problem]:
    for index, name in enumerate(names):
        if name in names[:index]:
            yield (kind, index, "name"), f"`name` is taken: {name!r} stands there already"


def _named_alike(config: Config) -> Iterator[Problem]:
    """Devices of one name in different tables."""
    owners: dict[str, str] = {wheel.name: "wheel" for wheel in config.wheel}
    named = {"sensor": [each.name for each in config.sensor], "gyro": [each.name for each in config.gyro]}
    for kind, names in named.items():
        for index, name in enumerate(names):
            owner = owners.setdefault(name, kind)
            if owner != kind:
                yield (kind, index, "name"), f"`name` is taken: there is a [[{owner}]] named {name!r}"


def _ports_taken(config: Config) -> Iterator[Problem]:
    """Of CAN only the interface says what a channel is."""
    owners: dict[tuple[str, str], str] = {}
    for index, bus in enumerate(config.bus):
        owner = owners.setdefault((bus.interface if bus.kind == "can" else "", bus.port), bus.name)
        if owner != bus.name:
            yield ("bus", index, "port"), f"`port` is taken: {bus.port!r} is that of bus {owner!r}"


def _without_bus(kind: str, named: list[str | None], config: Config) -> Iterator[Problem]:
    buses = [bus.name for bus in config.bus]
    for index, name in enumerate(named):
        if name is not None and name not in buses:
            yield (kind, index, "bus"), f"there is no [[bus]] named {name!r}{nearest(name, buses)}"


def _outputs_amiss(config: Config) -> Iterator[Problem]:
    """Outputs that go to one place, or to a bus that can't take them."""
    buses = {bus.name: bus for bus in config.bus}
    labels = [output.label for output in config.output]
    for index, output in enumerate(config.output):
        place: Place = ("output", index)
        bus = buses.get(output.bus or "")
        if output.label in labels[:index]:
            yield place, f"a second [[output]] to {output.label}: take one out"
        if bus is not None and bus.kind != "can":
            yield (*place, "bus"), f"bus {bus.name!r} is no CAN bus, and this output needs one"
        elif bus is not None and bus.listen_only:
            yield (*place, "bus"), f"bus {bus.name!r} has listen_only = true: nothing can be told there"


def _misfires(config: Config) -> Iterator[Problem]:
    sensors = [sensor.name for sensor in config.sensor]
    fired = [name for group in config.firing.groups for name in group]
    if not all(config.firing.groups):
        yield ("firing", "groups"), "a group without rangers: take it out"
    for name in sorted(set(fired)):
        if name not in sensors:
            yield ("firing", "groups"), f"there is no [[sensor]] named {name!r}{nearest(name, sensors)}"
        if fired.count(name) > 1:
            yield ("firing", "groups"), f"{name!r} stands in two groups"


def _of_another_drive(config: Config) -> Iterator[Problem]:
    """What is said of the wheels but means nothing to the kind of drive that they make."""
    robot, unsaid = config.robot, RobotConfig()
    others = {True: ("track_m", "wheel_ratio", "slip_factor"), False: ("wheelbase_m", "steering_error_deg")}
    for key in others[robot.wheels.steered]:
        if getattr(robot, key) != getattr(unsaid, key):
            yield ("robot", key), f'`{key}` means nothing with drive = "{robot.drive}": take it out'
    for index, wheel in enumerate(config.wheel):
        if robot.drive == "ackermann" and (wheel.most_deg or 0.0) > 85.0:
            yield ("wheel", index, "most_deg"), '`most_deg` must be at most 85 with drive = "ackermann"'


def _located(path: Path, text: str, problems: Iterable[Problem]) -> list[str]:
    """One line for each problem, in the order of the file."""
    lines = key_lines(text)
    numbered = [(_line(lines, place), described(place, what)) for place, what in problems]
    return [
        f"{path}:{line}: {what}" if line else f"{path}: {what}"
        for line, what in sorted(numbered, key=itemgetter(0))
    ]


def _line(lines: dict[Place, int], place: Place) -> int:
    """The line of the key, or of the innermost table around it; 0 if neither is in the file."""
    known = (place[:end] for end in range(len(place), 0, -1) if place[:end] in lines)
    return next((lines[each] for each in known), 0)
