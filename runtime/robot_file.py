"""Reading robot.toml: every error at once, with file, line, key and reason."""

import tomllib
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path
from typing import Any

from echogrid.runtime.config import Config, SensorConfig, WheelConfig
from echogrid.runtime.errors import UsageError
from echogrid.runtime.toml_lines import Place, key_lines
from echogrid.runtime.toml_values import Problem, hint, structured


def load(path: Path) -> Config:
    """The file's configuration. Raises UsageError with one line for every problem."""
    try:
        text = path.read_text(encoding="utf-8")
        table = tomllib.loads(text)
    except OSError as error:
        raise UsageError(
            [f"{path}: {error.strerror or error} (a robot is described by a robot.toml)"]
        ) from error
    except (UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise UsageError([f"{path}: not TOML: {error}"]) from error
    config, problems = _checked(table)
    if config is None or problems:
        raise UsageError([_located(path, key_lines(text), place, what) for place, what in problems])
    return config


def _checked(table: dict[str, Any]) -> tuple[Config | None, list[Problem]]:
    config, problems = structured(_with_settings_apart(table), Config)
    return config, problems if config is None else list(_contradictions(config))


def _with_settings_apart(table: dict[str, Any]) -> dict[str, Any]:
    """Move the keys which are a driver's own into `settings`, where there is a driver."""
    result = dict(table)
    for name, kind in (("sensor", SensorConfig), ("wheel", WheelConfig)):
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
    yield from _without_bus("sensor", [sensor.bus for sensor in config.sensor], config)
    yield from _without_bus("wheel", [wheel.bus for wheel in config.wheel], config)
    yield from _misfires(config)
    if not config.sensor:
        yield (), "no [[sensor]]: at least one is needed"


def _taken(kind: str, names: list[str]) -> Iterator[Problem]:
    for index, name in enumerate(names):
        if name in names[:index]:
            yield (kind, index, "name"), f"`name` is taken: {name!r} stands there already"


def _without_bus(kind: str, named: list[str | None], config: Config) -> Iterator[Problem]:
    buses = {bus.name for bus in config.bus}
    for index, name in enumerate(named):
        if name is not None and name not in buses:
            yield (kind, index, "bus"), f"there is no [[bus]] named {name!r}{hint(name, buses)}"


def _misfires(config: Config) -> Iterator[Problem]:
    sensors = {sensor.name for sensor in config.sensor}
    fired = [name for group in config.firing.groups for name in group]
    for name in sorted(set(fired)):
        if name not in sensors:
            yield ("firing", "groups"), f"there is no [[sensor]] named {name!r}{hint(name, sensors)}"
        if fired.count(name) > 1:
            yield ("firing", "groups"), f"{name!r} stands in two groups"


def _located(path: Path, lines: dict[Place, int], place: Place, what: str) -> str:
    known = next((place[:end] for end in range(len(place), 0, -1) if place[:end] in lines), None)
    line = f":{lines[known]}" if known else ""
    table = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in place).lstrip(".")
    return f"{path}{line}: {table}: {what}" if table else f"{path}{line}: {what}"
