"""Drive modes through all bytes: emulated rangers and motors, whose wheels move the robot in a room."""

from collections.abc import Iterator
from dataclasses import replace
from math import hypot, pi
from pathlib import Path

import pytest
from pytest import approx, fixture

from echogrid.drivers.throttle import FRESH_NS
from echogrid.mapping.twist import Twist
from echogrid.runtime import robot_file
from echogrid.runtime.config import Config, LoopConfig
from echogrid.runtime.emulated import DEFAULT_ROBOT
from echogrid.runtime.errors import ConfigError
from echogrid.runtime.modes import making
from echogrid.runtime.modes.guard import Guard
from echogrid.runtime.simulated_run import simulated_run
from echogrid.runtime.socket_wishes import SocketWishes, unix_socket
from echogrid.runtime.voyage import Leg

from .driven_run import START, Drive, Wisher, room

AHEAD = Twist(0.4)
READY_S = 4.0
"""After that the motors are enabled, and everything was seen."""


@fixture(scope="module")
def config() -> Config:
    return robot_file.load(DEFAULT_ROBOT)


@fixture
def wisher(tmp_path: Path) -> Iterator[Wisher]:
    made = Wisher(tmp_path / "wishes")
    yield made
    made.sender.close()


@fixture
def guarded(config: Config, wisher: Wisher) -> Iterator[Drive]:
    """Told what to do, in an empty room; it stands 6.5 m before a wall."""
    wishes = SocketWishes(unix_socket(wisher.address))
    drive = Drive(config, Guard(wishes), room(), wisher)
    drive.live(READY_S)
    yield drive
    wishes.close()


def goto(config: Config, x: float, y: float, *furniture: tuple[float, float, float, float]) -> Drive:
    return Drive(config, making.goto(config, x, y), room(*furniture))


def test_it_goes_around_what_stands_in_its_way_and_lets_the_motors_go_at_the_goal(config: Config) -> None:
    drive = goto(config, 5.0, 0.0, (3.6, 2.0, 4.2, 3.2))
    drive.go(90.0)
    end = drive.voyage.end
    assert end
    assert end.reached, end.told
    assert drive.voyage.leg is Leg.OVER
    last = drive.poses[-1]
    assert hypot(last.x - START.x - 5.0, last.y - START.y) < 0.2
    assert drive.nearest() > 0.05
    assert max(abs(pose.y - START.y) for pose in drive.poses) > 0.5
    report = drive.run.report([])["drive"]
    assert report["mode"] == "goto"
    assert report["distance_m"] == approx(drive.run.travelled, abs=1e-3)
    assert report["end"].startswith("there: ")


def test_where_there_is_no_way_it_ends_and_says_so(config: Config) -> None:
    pen = (0.6, 1.6, 0.7, 3.4), (0.7, 3.3, 2.5, 3.4), (0.7, 1.6, 2.5, 1.7), (2.4, 1.7, 2.5, 3.3)
    drive = goto(config, 5.0, 0.0, *pen)
    drive.go(90.0)
    end = drive.voyage.end
    assert end
    assert not end.reached
    assert end.told.startswith("stuck: ")
    assert drive.voyage.leg is Leg.OVER
    assert drive.nearest() > 0.0


def test_motors_that_are_never_ready_end_a_drive_to_a_goal(config: Config) -> None:
    drive = goto(config, 5.0, 0.0)
    drive.robot.fault("left", "off", drive.now_ns)
    drive.go(60.0)
    assert drive.voyage.end
    assert "the motors are not ready: left: silent: no heartbeat" in drive.voyage.end.told
    assert drive.run.travelled == 0.0


def test_a_motor_that_fails_under_way_stops_it_until_it_is_well_again(config: Config) -> None:
    drive = goto(config, 5.0, 0.0)
    drive.live(READY_S)
    drive.robot.fault("left", "motor_failed", drive.now_ns, 10**9)
    drive.live(1.0)
    assert drive.asked[-1] == Twist()
    drive.live(40.0)
    assert drive.voyage.end
    assert drive.voyage.end.reached
    assert drive.voyage.report()["stops"]["motors"] == 1


def test_a_wish_straight_at_a_wall_is_heeded_until_that_is_near(guarded: Drive, wisher: Wisher) -> None:
    wisher.wish = AHEAD
    guarded.live(4.0)
    assert guarded.asked[-1].speed == approx(0.4)
    guarded.live(25.0)
    assert guarded.asked[-1] == Twist()
    assert guarded.told[-1] == "guard: held"
    assert 0.05 < 8.0 - guarded.poses[-1].x - 0.24 < 0.6
    assert guarded.voyage.report()["stops"]["obstacles"] >= 1


def test_before_a_wall_it_may_turn_and_back_off(guarded: Drive, wisher: Wisher) -> None:
    wisher.wish = AHEAD
    guarded.live(25.0)
    stood = guarded.poses[-1]
    wisher.wish = Twist(0.3, 0.6)
    guarded.live(1.0)
    assert near(guarded.asked[-1], Twist(0.0, 0.6))
    guarded.live(2.0)
    assert guarded.poses[-1].yaw > stood.yaw + 1.0
    wisher.wish = Twist(0.0, -0.6)
    guarded.live(3.0)
    wisher.wish = Twist(-0.2)
    guarded.live(3.0)
    assert guarded.poses[-1].x < stood.x - 0.2


def near(one: Twist, other: Twist) -> bool:
    return (one.speed, one.turn_rate) == approx((other.speed, other.turn_rate), abs=1e-6)


def test_a_wish_beyond_the_limits_is_the_same_curve_within_them(guarded: Drive, wisher: Wisher) -> None:
    wisher.wish = Twist(5.0, 1.0)
    guarded.live(1.0)
    asked = guarded.asked[-1]
    assert asked.speed <= 0.5
    assert asked.turn_rate / asked.speed == approx(0.2)


def test_nobody_who_wishes_any_more_is_nobody_who_wants_to_move(guarded: Drive, wisher: Wisher) -> None:
    wisher.wish = AHEAD
    guarded.live(3.0)
    assert guarded.asked[-1].speed > 0.3
    wisher.wish = None
    guarded.live(0.4)
    assert guarded.asked[-1] == Twist()
    assert guarded.told[-1] == "guard: driving"


def test_what_was_wished_for_while_it_could_not_drive_counts_for_nothing(
    guarded: Drive, wisher: Wisher
) -> None:
    guarded.robot.fault("left", "motor_failed", guarded.now_ns, 10**9)
    wisher.wish = AHEAD
    guarded.live(0.9)
    wisher.wish = None
    guarded.live(3.0)
    assert guarded.told[-1] == "guard: driving"
    assert set(guarded.asked[-150:]) == {Twist()}


def test_without_a_ranger_that_looks_ahead_it_creeps_where_unknown_is_slow(
    guarded: Drive, wisher: Wisher
) -> None:
    wisher.wish = AHEAD
    guarded.live(4.0)
    guarded.robot.fault("ring_0", "off", guarded.now_ns)
    guarded.live(2.0)
    assert 0.0 < guarded.asked[-1].speed <= 0.1
    view = guarded.run.fusion.view(guarded.now_ns, AHEAD)
    assert (view.reason, view.silent) == (None, ("ring_0",))
    wisher.wish = Twist(-0.2)
    guarded.live(1.0)
    assert guarded.asked[-1].speed < -0.05


def test_after_a_pause_it_stands_before_it_drives_again(guarded: Drive, wisher: Wisher) -> None:
    wisher.wish = AHEAD
    guarded.live(4.0)
    before = guarded.poses[-1]
    guarded.pause(2.0)
    guarded.live(0.4)
    assert guarded.told[-1] == "guard: enabling the motors"
    assert guarded.asked[-1] == Twist()
    # For no longer than a rate is fresh, and until its motors stop, it went on meanwhile.
    assert guarded.poses[-1].x - before.x < 0.4 * (FRESH_NS * 1e-9 + 0.5)
    guarded.live(2.0)
    assert guarded.asked[-1].speed > 0.1


def wandered(config: Config, seed: int) -> Drive:
    drive = Drive(config, making.wander(config, seed), room((4.0, 0.0, 4.1, 5.0)))
    drive.go(20.0)
    return drive


def test_it_wanders_without_touching_anything_and_one_seed_is_one_way(config: Config) -> None:
    drive = wandered(config, 1)
    assert drive.run.travelled > 2.0
    assert drive.nearest() > 0.0
    assert drive.voyage.leg is Leg.OVER
    assert drive.voyage.end is None
    assert drive.poses == wandered(config, 1).poses != wandered(config, 2).poses
    assert max(pose.yaw for pose in drive.poses) - min(pose.yaw for pose in drive.poses) > pi / 2.0


def test_a_drive_whose_time_is_over_stops_and_lets_the_motors_go(config: Config) -> None:
    drive = goto(config, 5.0, 0.0)
    drive.go(6.0)
    assert drive.run.travelled > 0.2
    assert drive.voyage.leg is Leg.OVER
    assert drive.asked[-1] == Twist()
    assert drive.told[-1] == "goto: over"
    assert drive.poses[-1] == drive.poses[-4]
    assert drive.voyage.end is None


def test_a_loop_that_is_too_slow_to_drive_by_is_quickened(config: Config) -> None:
    assert making.brisk(replace(config, loop=LoopConfig(5.0))).loop.rate_hz == 20.0
    assert making.brisk(config) == config


def test_wheels_that_can_t_be_driven_are_refused(config: Config) -> None:
    deaf = replace(
        config, wheel=tuple(replace(wheel, driver="ak-servo", settings={}) for wheel in config.wheel)
    )
    with pytest.raises(ConfigError, match="left can't be driven: its driver only listens"):
        simulated_run(deaf, 1, mode=making.goto(deaf, 1.0, 0.0))
    steered = replace(config, robot=replace(config.robot, drive="tricycle"))
    with pytest.raises(ConfigError, match="the mode goto needs a differential one"):
        simulated_run(steered, 1, mode=making.goto(steered, 1.0, 0.0))
