"""Pilots that steer by the local grid, in the closed loop."""

from math import hypot

import pytest

from echogrid.mapping.pose import Pose
from echogrid.runtime.trials.drive import Drive
from echogrid.runtime.trials.job import Job
from echogrid.runtime.trials.pilots import PILOTS


def driven(world: str, pilot: str) -> Drive:
    return Drive(Job(world, 1, pilot, "ring-16", "none", False), PILOTS)


@pytest.mark.parametrize("world", ["corridor", "legs"])
def test_vfh_plus_comes_to_the_goal_and_touches_nothing(world: str) -> None:
    verdict = driven(world, "vfh-plus").done()
    assert verdict.outcome == "reached"
    assert not verdict.bumps
    assert verdict.spl > 0.8


@pytest.mark.parametrize("world", ["corridor", "legs"])
def test_who_has_a_floor_plan_comes_to_the_goal_touches_nothing_and_knows_where_it_is(world: str) -> None:
    drive = driven(world, "guided")
    verdict = drive.done()
    assert verdict.outcome == "reached"
    assert not verdict.bumps
    tracker = drive._pilot.tracker
    assert tracker is not None
    truth = Pose(*drive.course.start).inverse().compose(Pose(*drive.plant.pose_at(drive.plant.now_ns)))
    assert hypot(tracker.pose.x - truth.x, tracker.pose.y - truth.y) < 0.05
    assert not tracker.is_lost
