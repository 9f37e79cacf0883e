from math import cos, sin
from pathlib import Path

import numpy as np
import pytest

from echogrid.emulation.offices import office, office_tour
from echogrid.emulation.truth import truth
from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.pose import Pose
from echogrid.runtime import recording
from echogrid.runtime.errors import UsageError
from echogrid.runtime.office_truth import begin_s, in_office
from echogrid.runtime.recording import Recording
from echogrid.runtime.robond import configuration

TOUR = office_tour()


def driven(start_s: float, seconds: float = 40.0, frame: Pose | None = None) -> list[tuple[int, Pose]]:
    """Poses along the tour, as seen in a frame that stands where they begin."""
    back = Pose(*TOUR.pose(start_s)).inverse()
    times = np.arange(0.0, seconds, 0.1)
    seen = [back.compose(Pose(*TOUR.pose(start_s + time_s))) for time_s in times]
    return [
        (round(time_s * 1e9), (frame or Pose()).compose(each))
        for time_s, each in zip(times, seen, strict=True)
    ]


@pytest.mark.parametrize("start_s", [0.0, 0.7, 33.333, 200.0, 290.0])
@pytest.mark.parametrize("frame", [Pose(), Pose(3.0, -2.0, 1.0)])
def test_where_a_log_began_is_found_anywhere_on_the_tour(start_s: float, frame: Pose) -> None:
    found = begin_s(TOUR, driven(start_s, frame=frame))
    here, there = TOUR.pose(start_s), TOUR.pose(found)
    assert np.hypot(here[0] - there[0], here[1] - there[1]) < 0.002
    assert abs(here[2] - there[2]) < 0.01


def test_the_poses_come_out_in_the_frame_of_the_office() -> None:
    told = Recording(configuration(), driven(50.0, frame=Pose(1.0, 1.0, -0.5)))
    moved, _ = in_office(told)
    for stamp_ns, pose in moved.poses[::40]:
        x, y, _ = TOUR.pose(50.0 + stamp_ns * 1e-9)
        assert np.hypot(pose.x - x, pose.y - y) < 0.002


def test_the_truth_is_the_office_itself() -> None:
    _, found = in_office(Recording(configuration(), driven(0.0)))
    lattice = found.lattice(GridGeometry(0.1, 0.0, 0.0, 100, 140))
    walls, free = found.on(lattice)
    x, y, _ = TOUR.pose(0.0)
    due = truth(office(), lattice.x_centres, lattice.y_centres, (x, y))
    np.testing.assert_array_equal(walls, due[0])
    np.testing.assert_array_equal(free, due[1])


def test_a_simulated_log_is_laid_where_the_robot_was(simulated: Path) -> None:
    moved, _ = in_office(recording.read_simple(simulated / "log"))
    stamp_ns, pose = moved.poses[-1]
    x, y, _ = TOUR.pose(stamp_ns * 1e-9 - 1.0)
    assert np.hypot(pose.x - x, pose.y - y) < 0.02


def test_a_path_of_elsewhere_is_refused() -> None:
    turns = [0.03 * step for step in range(300)]
    places = [Pose(3.0 * sin(turn), 3.0 - 3.0 * cos(turn), turn) for turn in turns]
    circle = [(step * 100_000_000, place) for step, place in enumerate(places)]
    with pytest.raises(UsageError, match=r"m off the office's tour at best: .*--simulate"):
        in_office(Recording(configuration(), circle))


def test_a_log_without_a_pose_is_refused() -> None:
    with pytest.raises(UsageError, match="no usable pose"):
        in_office(Recording(configuration()))
