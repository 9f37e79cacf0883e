"""What is true where a log was made in the built-in office: the office itself, and where the log began."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from echogrid.emulation.offices import office
from echogrid.emulation.round import Round
from echogrid.emulation.truth import truth
from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.metrics import Mask
from echogrid.mapping.pose import Pose
from echogrid.runtime.emulated import office_round
from echogrid.runtime.errors import UsageError
from echogrid.runtime.loop import SECOND_NS
from echogrid.runtime.recording import Recording

Floats = NDArray[np.float64]

_LOOK_S = 60.0
"""So much of the log is laid along the tour; dead reckoning is true for longer."""
_LOOKS = 60
_COARSE_S, _FINE_S = 0.05, 0.001
_LEVER_M = 0.3
"""What a turn of 1 rad counts for."""
_LIKE_M = 0.15
"""A log that fits worse anywhere on the tour was made elsewhere."""


@dataclass(frozen=True, slots=True)
class OfficeTruth:
    """The built-in office, whatever the cells."""

    inside: tuple[float, float]
    """m: a point that the robot can reach."""

    def lattice(self, area: GridGeometry) -> GridGeometry:
        """The cells are those of the log's map."""
        return area

    def on(self, lattice: GridGeometry) -> tuple[Mask, Mask]:
        """Walls, and free cells that can be reached."""
        return truth(office(), lattice.x_centres, lattice.y_centres, self.inside)


def in_office(recording: Recording) -> tuple[Recording, OfficeTruth]:
    """The recording with its poses in the office's frame, and the office.

    Raises UsageError if that log is of no emulated robot on its tour, or has no pose.
    """
    if not recording.poses:
        raise UsageError(["no usable pose: nothing can be placed", *recording.faults.lines()])
    tour = office_round(recording.config)
    start = Pose(*tour.pose(begin_s(tour, recording.poses)))
    back = recording.poses[0][1].inverse()
    poses = [(stamp_ns, start.compose(back.compose(pose))) for stamp_ns, pose in recording.poses]
    return replace(recording, poses=poses), OfficeTruth((start.x, start.y))


def begin_s(tour: Round, poses: list[tuple[int, Pose]]) -> float:
    """When on its tour the robot was at the first of the poses: whence the tour is most like them.

    Raises UsageError if it is nowhere like them.
    """
    since_s, seen = _looks(poses)
    coarse = np.arange(0.0, tour.lap_time + tour.wait, _COARSE_S)
    around = coarse[_best(tour, coarse, since_s, seen)[0]] + np.arange(-_COARSE_S, _COARSE_S, _FINE_S)
    fine = around[around >= 0.0]
    index, error = _best(tour, fine, since_s, seen)
    if error > _LIKE_M:
        told = f"the log's path is {error:.2f} m off the office's tour at best"
        raise UsageError([f"{told}: it was not made by `echogrid run --simulate` or `echogrid emulate`"])
    return float(fine[index])


def _looks(poses: list[tuple[int, Pose]]) -> tuple[Floats, Floats]:
    """Times (n,) since the first pose, and what was driven till then, (n, 4): x, y, and a lever's end."""
    stamps = np.array([stamp_ns for stamp_ns, _ in poses])
    since_s = (stamps - stamps[0]) / SECOND_NS
    last = int(np.searchsorted(since_s, _LOOK_S, side="right")) - 1
    chosen = np.unique(np.linspace(0, last, _LOOKS).astype(np.intp))
    places = np.array([[pose.x, pose.y, pose.yaw] for _, pose in poses])
    return since_s[chosen], _driven(places[:1], places[chosen])


def _best(tour: Round, begins_s: Floats, since_s: Floats, seen: Floats) -> tuple[int, float]:
    """Which of the times is most like a beginning, and how far (m) the tour is then off what was seen."""
    step = begins_s[1] - begins_s[0]
    times = np.arange(begins_s[0], begins_s[-1] + since_s[-1] + 2.0 * step, step)
    track = np.array([tour.pose(time_s) for time_s in times]).T
    errors = []
    for begin in begins_s:
        there = np.column_stack([np.interp(begin + since_s, times, column) for column in track])
        errors.append(np.sqrt(((_driven(there[:1], there) - seen) ** 2).sum(axis=1).mean()))
    best = int(np.argmin(errors))
    return best, float(errors[best])


def _driven(start: Floats, poses: Floats) -> Floats:
    """(n, 4) of poses (n, 3) as seen from one (1, 3): x, y (m) and where the end of a lever points."""
    dx, dy = poses[:, 0] - start[:, 0], poses[:, 1] - start[:, 1]
    c, s = np.cos(start[:, 2]), np.sin(start[:, 2])
    yaw = poses[:, 2] - start[:, 2]
    return np.column_stack([c * dx + s * dy, c * dy - s * dx, _LEVER_M * np.cos(yaw), _LEVER_M * np.sin(yaw)])
