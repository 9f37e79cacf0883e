"""The wheels' measures in robot.toml, mended by recorded runs."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import degrees, isnan
from pathlib import Path
from typing import TypeVar

import numpy as np

from echogrid.mapping import wheel_runs
from echogrid.mapping.kinematics import Differential
from echogrid.mapping.wheel_runs import Point, WheelRun
from echogrid.runtime import assembly, map_files, robot_file, simple_log
from echogrid.runtime.config import Config
from echogrid.runtime.errors import UsageError
from echogrid.runtime.hardware_config import RobotConfig
from echogrid.runtime.recording import wheel_rows
from echogrid.runtime.simple_log import RowFaults
from echogrid.runtime.toml_edit import with_values

T = TypeVar("T")

MEASURES = ("wheel_radius_m", "wheel_ratio", "track_m", "slip_factor")
"""The keys of [robot] which calibration may change; of a steered drive's only the first."""
ZERO = "zero_deg"
"""The key of its steering, which it may change as well."""


@dataclass(frozen=True, slots=True)
class Logs:
    """Recorded runs of one robot."""

    folders: tuple[Path, ...]
    config: Config
    runs: tuple[WheelRun, ...]
    faults: RowFaults


@dataclass(frozen=True, slots=True)
class Calibration:
    """The measures before and after, and in words what they are worth."""

    old: RobotConfig
    new: RobotConfig
    worth: tuple[str, ...]
    zeros: tuple[float, float] | None = None
    """Of the steering, before and after, deg."""

    def lines(self) -> Iterator[str]:
        """What a person is told."""
        yield f"{'':16}{'old':>12}{'new':>12}"
        for key in MEASURES[:1] if self.zeros else MEASURES:
            old, new = getattr(self.old, key), getattr(self.new, key)
            if key != "slip_factor" or old != 1.0:
                yield f"{key:16}{old:12.7g}{new:12.7g}"
        if self.zeros:
            yield f"{ZERO:16}{self.zeros[0]:12.7g}{self.zeros[1]:12.7g}"
        yield from self.worth


def read(folders: Sequence[Path], ends: Mapping[Path, Point]) -> Logs:
    """The wheels' runs in these simple logs; one which has no end given ended on its start.

    Raises UsageError with everything that keeps them from being read.
    """
    problems = [f"{folder}: an end is given, but it is no LOG" for folder in ends if folder not in folders]
    configs = []
    for folder in folders:
        try:
            configs.append(config := robot_file.load(folder / "robot.toml"))
            problems += simple_log.unusable_wheels(folder, config.robot.wheels)
        except UsageError as error:
            problems += [*simple_log.unusable_wheels(folder, None), *error.problems]
    if problems:
        raise UsageError(problems)
    faults = RowFaults()
    runs = tuple(
        _run(folder, config, ends.get(folder, (0.0, 0.0)), faults)
        for folder, config in zip(folders, configs, strict=True)
    )
    for folder, config in zip(folders, configs, strict=True):
        with robot_file.located(folder / "robot.toml"):
            assembly.drive(config)
        if _measures(config) != _measures(configs[0]):
            problems.append(f"{folder}/robot.toml: other measures than {folders[0]}/robot.toml has")
    if problems:
        raise UsageError(problems)
    return Logs(tuple(folders), configs[0], runs, faults)


def by_squares(logs: Logs) -> Calibration:
    """Unequal wheels and the track, by UMBmark. Raises UsageError when the runs are no squares both ways."""
    before = assembly.drive(logs.config)
    if not isinstance(before, Differential):
        kind = logs.config.robot.drive
        mend = "let it go straight on, and give --straight METRES"
        raise UsageError([f'squares are for a differential drive, and this is drive = "{kind}": {mend}'])
    odd = [
        f"{folder}: no square: it went {end.travelled:.2f} m and turned {degrees(end.turned):.0f} deg "
        "(a run is one square of 0.5 m sides or more, with the last turn back to how it stood at first)"
        for folder, run in zip(logs.folders, logs.runs, strict=True)
        if not wheel_runs.is_square(end := wheel_runs.dead_reckoned(run, before))
    ]
    if odd:
        raise UsageError(odd)
    drive = _mended(lambda: wheel_runs.from_squares(logs.runs, before))
    old, new = (wheel_runs.square_errors(logs.runs, each) for each in (before, drive))
    worth = (
        f"worst systematic end error of squares of {new.side:.2f} m: {old.worst:.4f} m -> {new.worst:.4f} m",
        "with one run a direction nobody knows what of this was chance: drive more"
        if isnan(new.scatter)
        else f"single runs scatter around their mean by {new.scatter:.4f} m (rms): chance, which stays",
    )
    robot = logs.config.robot
    key = "track_m" if robot.slip_factor == 1.0 else "slip_factor"
    found = {key: getattr(robot, key) * drive.track / before.track}
    found["wheel_ratio"] = drive.right_radius / drive.left_radius
    return Calibration(robot, _mended(lambda: replace(robot, **found)), worth)


def by_straights(logs: Logs, length: float) -> Calibration:
    """The wheels' mean radius, and the steering's zero, by straight runs of that length (m).

    Raises UsageError.
    """
    runs = [replace(run, end=(length, 0.0)) for run in logs.runs]
    before = assembly.drive(logs.config)
    mended, zeros = runs, None
    if not isinstance(before, Differential):
        zero = _mended(lambda: wheel_runs.straight_zero(runs, before))
        mended = [wheel_runs.with_zero(run, zero) for run in runs]
        zeros = _zero(logs.config), _zero(logs.config) + degrees(zero)
    scale = _mended(lambda: wheel_runs.straight_scale(mended, before))
    robot = logs.config.robot
    found = _mended(lambda: replace(robot, wheel_radius_m=(robot.wheel_radius_m or 0.0) * scale))
    drive = assembly.drive(replace(logs.config, robot=found))
    old, new = wheel_runs.straight_error(runs, before), wheel_runs.straight_error(mended, drive)
    worth = (f"error of the way over {length:g} m (rms): {old:.4f} m -> {new:.4f} m",)
    return Calibration(robot, found, worth, zeros)


def write(path: Path, found: Calibration) -> list[str]:
    """Put the measures into a robot.toml, and nothing else; the keys that changed.

    Raises UsageError when that file is not a robot's, or can't be edited.
    """
    config = robot_file.load(path)
    old, new = config.robot, found.new
    values = {key: value for key in MEASURES if (value := getattr(new, key)) != getattr(old, key)}
    zero = {ZERO: found.zeros[1]} if found.zeros and found.zeros[1] != _zero(config) else {}
    try:
        edited = with_values(path.read_bytes().decode(), "robot", values)
        if zero:
            edited = with_values(edited, "wheel", zero, _steering(config))
    except ValueError as error:
        told = ", ".join(f"{key} = {value:.7g}" for key, value in (values | zero).items())
        raise UsageError([f"{path}: {error}: write it yourself: {told}"]) from error
    map_files.replace(path.resolve(), edited.encode())
    return [*values, *zero]


def _steering(config: Config) -> int:
    """Which [[wheel]] is steered. Raises ValueError if none is."""
    names = [wheel.name for wheel in config.wheel]
    if "steering" not in names:
        raise ValueError("it has no [[wheel]] named `steering`")
    return names.index("steering")


def _zero(config: Config) -> float:
    """Where its steering is straight ahead, deg."""
    return next((wheel.zero_deg for wheel in config.wheel if wheel.name == "steering"), 0.0)


def _run(folder: Path, config: Config, end: Point, faults: RowFaults) -> WheelRun:
    rows = wheel_rows(folder, config.robot.wheels, faults)
    angles = np.array([each.both for _, each in rows]).reshape(-1, 2)
    return WheelRun(angles, end)


def _measures(config: Config) -> tuple[object, ...]:
    return (config.robot.drive, _zero(config), *(getattr(config.robot, key) for key in MEASURES))


def _mended(find: Callable[[], T]) -> T:
    """What is found; a ValueError becomes a UsageError."""
    try:
        return find()
    except ValueError as error:
        raise UsageError([f"no calibration comes of these runs: {error}"]) from error
