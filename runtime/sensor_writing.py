"""What calibration puts into a robot.toml, and the sonar model beside it."""

from collections.abc import Sequence
from dataclasses import dataclass
from json import dumps
from math import degrees
from pathlib import Path

from echogrid.mapping.sensor_calibration import Beam, Estimate, Noise, Own
from echogrid.runtime import map_files, robot_file, sonar_model_file
from echogrid.runtime.config import Config
from echogrid.runtime.errors import UsageError
from echogrid.runtime.sensor_calibration import Result
from echogrid.runtime.toml_edit import with_values

SURELY = 3.0
"""Standard errors: by what a number must differ from the configured one to be changed."""
MODEL_FILE = "sonar_model.json"
_MODEL = {"model": "empirical", "model_file": MODEL_FILE}


@dataclass(frozen=True, slots=True)
class Mended:
    """What changes."""

    sensors: dict[str, dict[str, float]]
    """The keys of each [[sensor]]."""
    model: str
    """The text of the file; empty: none is better than what is configured."""


def mended(config: Config, results: Sequence[Result]) -> Mended:
    """What the results are worth to a robot.toml."""
    sensors = {
        config.sensor[own.sensor].name: values
        for result in results
        for own in result.found.own
        if (values := _values(config, own, result))
    }
    tables = [
        sonar_model_file.table(
            [config.sensor[index].name for index in result.kind.sensors],
            result.trial.pings,
            result.trial.factor,
            result.trial.model,
        )
        for result in results
        if result.trial and result.trial.skills.empirical > max(result.trial.skills.configured, 0.0)
    ]
    return Mended(sensors, sonar_model_file.text(tables) if tables else "")


def write(path: Path, found: Mended) -> list[str]:
    """Put it into a robot.toml, and the model beside it; what changed.

    Raises UsageError when that file is not that robot's, or can't be edited.
    """
    config = robot_file.load(path)
    names = [sensor.name for sensor in config.sensor]
    if strange := [name for name in found.sensors if name not in names]:
        raise UsageError(
            [f"{path}: it has no [[sensor]] named {name!r}: is it another robot?" for name in strange]
        )
    text, told = path.read_bytes().decode(), []
    try:
        for name, values in found.sensors.items():
            text = with_values(text, "sensor", values, names.index(name))
            told += [f"{name}: {', '.join(values)}"]
        if found.model:
            text = with_values(text, "map", _MODEL)
            told += [f'model = "empirical" ({MODEL_FILE})']
    except ValueError as error:
        raise UsageError([f"{path}: {error}: {_by_hand(found)}"]) from error
    if found.model:
        map_files.replace(path.resolve().with_name(MODEL_FILE), found.model.encode())
    map_files.replace(path.resolve(), text.encode())
    return told


def _values(config: Config, own: Own, result: Result) -> dict[str, float]:
    """Its keys, with what they should be.

    The band of an echo is only made thicker: it holds what walls and poses are off, too, not noise alone.
    """
    values: dict[str, float] = {}
    sensor = config.sensor[own.sensor]
    beam, noise, trial = result.found.beam, result.found.noise, result.trial
    if isinstance(own.yaw, Estimate) and abs(own.yaw.value) > SURELY * own.yaw.error:
        values["yaw_deg"] = round(sensor.yaw_deg + degrees(own.yaw.value), 2)
    if isinstance(beam, Beam) and trial and trial.skills.found > trial.skills.configured:
        half = own.half_angle if isinstance(own.half_angle, Estimate) else beam.half_angle
        values["half_angle_deg"] = round(degrees(half.value), 1)
    thick = config.map.tolerance_m if sensor.tolerance_m is None else sensor.tolerance_m
    if isinstance(noise, Noise) and (needed := 2.0 * noise.model.sigma(noise.farthest)) > thick:
        values["tolerance_m"] = round(needed, 3)
    return values


def _by_hand(found: Mended) -> str:
    told = [
        f"{name}: {', '.join(f'{key} = {value:g}' for key, value in values.items())}"
        for name, values in found.sensors.items()
    ]
    if found.model:
        told += [f"[map] {', '.join(f'{key} = {dumps(value)}' for key, value in _MODEL.items())}"]
    return f"write it yourself: {'; '.join(told)}"
