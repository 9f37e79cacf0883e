"""The pilots without a map, by what they do about what they hear."""

from dataclasses import replace
from math import degrees, pi

import numpy as np
import pytest

from echogrid.drivers.readings import Outcome, RangeReading
from echogrid.mapping.placed_ping import PlacedPing
from echogrid.mapping.planning.floor_plan import FloorPlan
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.twist import Twist
from echogrid.runtime import assembly
from echogrid.runtime.config import DriveConfig
from echogrid.runtime.trials.pilot import STANDING, Robot
from echogrid.runtime.trials.rigs import RIGS
from echogrid.runtime.trials.simple_pilots import Blind, SingleScan

CONFIG = RIGS["ring-16"]().config
NOWHERE = FloorPlan(np.empty((0, 2)), np.empty((0, 2)))
ROBOT = Robot(0.22, replace(CONFIG, drive=DriveConfig(0.5, degrees(1.5))), NOWHERE)
LOCAL = assembly.lookout(CONFIG).local
GOAL = Pose(5.0, 0.0)
HERE = Pose()
STEP_NS = 50_000_000


def ping(bearing, distance, stamp_ns=0):
    ranger = Ranger(f"at {bearing}", Pose(0.0, 0.0, bearing), 0.26, 0.15, 4.0)
    outcome = Outcome.NO_ECHO if distance is None else Outcome.ECHO
    reading = RangeReading(stamp_ns, 0, ranger.name, outcome, distance or 0.0)
    return PlacedPing(reading, ranger, ranger.mount)


def asked(pilot, pose=HERE, now_ns=STEP_NS, goal=GOAL):
    return pilot.step(now_ns, LOCAL, pose, STANDING, goal)


@pytest.mark.parametrize("pilot", [Blind(ROBOT), SingleScan(ROBOT)])
def test_the_way_is_straight_where_nothing_is_heard_and_ends_at_the_goal(pilot):
    assert asked(pilot) == Twist(0.5, 0.0)
    assert asked(pilot, goal=Pose(0.1, 0.05)) == STANDING


@pytest.mark.parametrize("pilot", [Blind(ROBOT), SingleScan(ROBOT)])
def test_a_goal_behind_is_turned_to_first(pilot):
    asked_for = asked(pilot, goal=Pose(-3.0, 0.5))
    assert asked_for.speed == 0.0
    assert asked_for.turn_rate == pytest.approx(1.5)


def test_an_echo_ahead_is_gone_around():
    pilot = SingleScan(ROBOT)
    pilot.hear(ping(0.0, 0.7))
    twist = asked(pilot)
    assert abs(twist.turn_rate) > 0.5
    assert twist.speed < 0.4


def test_an_echo_that_was_followed_by_silence_or_is_old_is_forgotten():
    for later, now_ns in ((ping(0.0, None), STEP_NS), (None, 1_000_000_000)):
        pilot = SingleScan(ROBOT)
        pilot.hear(ping(0.0, 0.7))
        if later:
            pilot.hear(later)
        assert asked(pilot, now_ns=now_ns) == Twist(0.5, 0.0)


def test_where_all_is_blocked_it_turns_on_the_spot():
    pilot = SingleScan(ROBOT)
    for index in range(16):
        pilot.hear(ping(index * pi / 8.0, 0.4))
    assert (asked(pilot).speed, asked(pilot).turn_rate) == pytest.approx((0.0, 0.75))


def test_who_is_held_backs_off_and_turns():
    pilot = SingleScan(ROBOT)
    twists = [asked(pilot) for _ in range(30)]
    assert twists[0].speed == 0.5
    assert any(twist.speed < 0.0 for twist in twists)
    assert any(twist.speed == 0.0 and twist.turn_rate == pytest.approx(0.75) for twist in twists)


def test_who_gets_on_goes_on():
    pilot = SingleScan(ROBOT)
    assert all(asked(pilot, Pose(0.001 * step)).speed == 0.5 for step in range(30))
