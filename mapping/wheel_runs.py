"""A drive's true measures, from runs whose ends were measured on the floor."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import hypot, nan, pi, radians, sqrt

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.kinematics import Ackermann, Differential, Kinematics, Tricycle
from echogrid.mapping.umbmark import corrections, worst_error

Point = tuple[float, float]

_ROUNDS = 8
_TOLERANCE = radians(60.0)
"""By how much the odometry of a bad robot may miss the full turn of a square."""
_SHORTEST = 2.0
"""m: a shorter way round shows nothing but the noise."""


@dataclass(frozen=True, slots=True)
class WheelRun:
    """What the wheels turned on a run, and where it ended."""

    angles: NDArray[np.float64]
    """(n, 2) float64: of both encoders, absolute and unwrapped, rad."""
    end: Point = (0.0, 0.0)
    """m from the start, x the way the robot first looked, y to its left; truly, by a tape measure."""


@dataclass(frozen=True, slots=True)
class End:
    """Where dead reckoning says that a run ended, from its start."""

    x: float
    y: float
    turned: float
    """rad, unwrapped."""
    travelled: float
    """m, the length of the path."""


@dataclass(frozen=True, slots=True)
class SquareErrors:
    """The end errors (absolute minus odometry, m) of square runs."""

    clockwise: Point
    """The mean of those runs."""
    counterclockwise: Point
    scatter: float
    """m: the rms distance of single runs from their direction's mean. No calibration mends it. NaN where a
    direction has one run."""
    side: float
    """m, of the squares, on average."""

    @property
    def worst(self) -> float:
        """E_max,syst, m."""
        return worst_error(self.clockwise, self.counterclockwise)


def dead_reckoned(run: WheelRun, drive: Kinematics) -> End:
    """The end of a run by exact arcs, as `Odometry` would have it."""
    forward, turn = _steps(run, drive)
    heading = np.cumsum(turn) - turn / 2.0
    chord = forward * np.sinc(turn / (2.0 * pi))
    return End(
        float((chord * np.cos(heading)).sum()),
        float((chord * np.sin(heading)).sum()),
        float(turn.sum()),
        float(abs(forward).sum()),
    )


def _steps(run: WheelRun, drive: Kinematics) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Ways ahead and turns from row to row; of a differential drive, whose squares are many, all at once."""
    if isinstance(drive, Differential):
        left, right = (np.diff(run.angles, axis=0) * (drive.left_radius, drive.right_radius)).T
        return (left + right) / 2.0, (right - left) / drive.track
    rows: list[tuple[float, float]] = [(first, second) for first, second in run.angles.tolist()]
    motions = [drive.motion(before, after) for before, after in pairwise(rows)]
    return np.array([each.forward for each in motions]), np.array([each.turn for each in motions])


def is_square(end: End) -> bool:
    """Whether a run may be one: it turned full circle, once, on a way of 2 m at least."""
    return abs(abs(end.turned) - 2.0 * pi) < _TOLERANCE and end.travelled >= _SHORTEST


def square_errors(runs: Sequence[WheelRun], drive: Differential) -> SquareErrors:
    """How wrong the odometry is. Raises ValueError unless there are runs in both directions."""
    ends = [dead_reckoned(run, drive) for run in runs]
    errors = [(run.end[0] - end.x, run.end[1] - end.y) for run, end in zip(runs, ends, strict=True)]
    sides = [
        [error for error, end in zip(errors, ends, strict=True) if end.turned * way > 0] for way in (-1, 1)
    ]
    if not all(sides):
        raise ValueError("squares in both directions are needed: some clockwise, some counter-clockwise")
    clockwise, counterclockwise = (_mean(side) for side in sides)
    apart = [
        hypot(x - middle[0], y - middle[1])
        for side, middle in zip(sides, (clockwise, counterclockwise), strict=True)
        for x, y in side
    ]
    scatter = nan if min(map(len, sides)) < 2 else sqrt(sum(d**2 for d in apart) / len(apart))
    side = sum(end.travelled for end in ends) / len(ends) / 4.0
    return SquareErrors(clockwise, counterclockwise, scatter, side)


def from_squares(runs: Sequence[WheelRun], drive: Differential) -> Differential:
    """The drive whose odometry ends where the runs did: UMBmark, repeated on the runs that it has mended.

    Its equations are of the first order, and one round leaves a twentieth of the error or so. The mean radius
    stays: squares do not show it. Raises ValueError unless there are runs in both directions.
    """
    for _ in range(_ROUNDS):
        errors = square_errors(runs, drive)
        clockwise, counterclockwise = _along(errors)
        found = corrections(clockwise, counterclockwise, errors.side, drive.track)
        left, right = drive.left_radius * found.left, drive.right_radius * found.right
        same_mean = (drive.left_radius + drive.right_radius) / (left + right)
        drive = replace(
            drive,
            left_radius=left * same_mean,
            right_radius=right * same_mean,
            track=drive.track * found.track_factor,
        )
    return drive


def straight_zero(runs: Sequence[WheelRun], drive: Tricycle | Ackermann) -> float:
    """rad: what the steering told, on average, while these runs went straight ahead.

    With it taken off, they end looking as they did at first, all in all. Raises ValueError when the wheels
    stood still.
    """
    zero = 0.0
    for _ in range(_ROUNDS):
        ends = [dead_reckoned(with_zero(run, zero), drive) for run in runs]
        way = sum(end.travelled for end in ends)
        if way <= 0.0:
            raise ValueError("the wheels did not turn")
        zero += sum(end.turned for end in ends) * drive.wheelbase / way
    return zero


def with_zero(run: WheelRun, zero: float) -> WheelRun:
    """The run of a steered drive, its steering counted from another zero (rad)."""
    return replace(run, angles=run.angles - (0.0, zero))


def straight_scale(runs: Sequence[WheelRun], drive: Kinematics) -> float:
    """The factor of the radii with which straight runs are, on average, as long as they were.

    Raises ValueError when the wheels stood still.
    """
    ends = [dead_reckoned(run, drive) for run in runs]
    reckoned = sum(hypot(end.x, end.y) for end in ends)
    if reckoned <= 0.0:
        raise ValueError("the wheels did not turn")
    return sum(hypot(*run.end) for run in runs) / reckoned


def straight_error(runs: Sequence[WheelRun], drive: Kinematics) -> float:
    """m: by how much, rms, the odometry of straight runs misses their length."""
    ends = [dead_reckoned(run, drive) for run in runs]
    missed = [hypot(*run.end) - hypot(end.x, end.y) for run, end in zip(runs, ends, strict=True)]
    return sqrt(sum(each**2 for each in missed) / len(missed))


def _along(errors: SquareErrors) -> Point:
    """The errors in x of both directions, each the mean of two estimates: to the first order the error in y
    is as large, and of the opposite sign when turning to the left."""
    (right_x, right_y), (left_x, left_y) = errors.clockwise, errors.counterclockwise
    return (right_x + right_y) / 2.0, (left_x - left_y) / 2.0


def _mean(points: Sequence[Point]) -> Point:
    xs, ys = zip(*points, strict=True)
    return sum(xs) / len(xs), sum(ys) / len(ys)
