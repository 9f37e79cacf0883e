"""Pilots that steer by the local grid, in the closed loop."""

import pytest

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
