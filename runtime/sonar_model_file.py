"""Empirical sonar models in a file: JSON, so that people can read it and every number keeps all its bits.

    {"echogrid": "sonar model", "version": 1, "models": [
      {"sensors": ["front", "left"], "pings": 4210, "factor": 0.2,
       "offset_m": [...], "bearing_rad": [...], "distance_m": [...],
       "of_echo": [[[...]]], "of_silence": [[...]]}]}

The borders of the bins rise; of_echo has (offset, bearing, reading) bins, of_silence (bearing, distance), one
less each than borders: nats, already multiplied by the factor.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from echogrid.mapping.empirical_model import Bins, Empirical
from echogrid.runtime.errors import UsageError, described
from echogrid.runtime.toml_values import structured

_MEND = "`echogrid calibrate sensor LOG --write robot.toml` makes a new one"


@dataclass(frozen=True, slots=True)
class ModelTable:
    """The model of one kind of rangers, as it stands in the file."""

    sensors: tuple[str, ...]
    pings: int
    """From so many it was counted."""
    factor: float
    """What all is multiplied by, since pings that follow each other are not independent."""
    offset_m: tuple[float, ...]
    bearing_rad: tuple[float, ...]
    distance_m: tuple[float, ...]
    of_echo: tuple[tuple[tuple[float, ...], ...], ...]
    of_silence: tuple[tuple[float, ...], ...]

    def __post_init__(self) -> None:
        self.model()

    def model(self) -> Empirical:
        """As maps use it. Raises ValueError when bins and tables do not fit."""
        bins = Bins(self.offset_m, self.bearing_rad, self.distance_m)
        return Empirical(bins, np.array(self.of_echo), np.array(self.of_silence))


@dataclass(frozen=True, slots=True)
class _File:
    echogrid: Literal["sonar model"]
    version: int
    models: tuple[ModelTable, ...]

    def __post_init__(self) -> None:
        if self.version != 1:
            raise ValueError(f"version {self.version} of the file; this program reads version 1")


def table(sensors: Sequence[str], pings: int, factor: float, model: Empirical) -> ModelTable:
    """A model as it stands in the file."""
    bins = model.bins
    borders = bins.offset, bins.bearing, bins.distance
    return ModelTable(
        tuple(sensors), pings, factor, *borders, model.of_echo.tolist(), model.of_silence.tolist()
    )


def text(tables: Sequence[ModelTable]) -> str:
    """The file's text."""
    models = ",\n".join(_lines(each) for each in tables)
    return f'{{"echogrid": "sonar model", "version": 1, "models": [\n{models}\n]}}\n'


def read(path: Path) -> Mapping[str, Empirical]:
    """The model of each sensor, by its name. Raises UsageError, one line for every problem."""
    try:
        value = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise UsageError([f"{path}: {error.strerror or error}: {_MEND}"]) from error
    except (ValueError, RecursionError) as error:
        raise UsageError([f"{path}: not JSON: {error}: {_MEND}"]) from error
    file, problems = structured(value, _File)
    if file is None:
        raise UsageError([f"{path}: {described(place, what)}: {_MEND}" for place, what in problems])
    return {sensor: each.model() for each in file.models for sensor in each.sensors}


def _lines(model: ModelTable) -> str:
    """One line for each key."""
    return (
        "{"
        + ",\n ".join(f"{json.dumps(key)}: {json.dumps(value)}" for key, value in asdict(model).items())
        + "}"
    )
