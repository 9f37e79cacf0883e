from math import pi

from hypothesis import given
from hypothesis.strategies import floats, integers, lists

from echogrid.drivers.readings import Outcome, RangeReading
from echogrid.mapping.pose import Pose
from echogrid.mapping.stuck import LEAST_READINGS, LEAST_TURN, StuckWatch


def echo(distance: float, sensor: str = "front") -> RangeReading:
    return RangeReading(0, 0, sensor, Outcome.ECHO, distance)


def turned(steps: int, distance: float = 1.0) -> StuckWatch:
    """A robot that turned by a tenth of a radian at each of so many readings."""
    watch = StuckWatch()
    for step in range(steps):
        watch.see(echo(distance), Pose(0.0, 0.0, 0.1 * step))
    return watch


def test_the_same_echo_all_around_is_stuck() -> None:
    assert turned(40).stuck() == {"front": 1.0}


def test_a_robot_that_stands_may_hear_the_same_for_ever() -> None:
    watch = StuckWatch()
    for _ in range(1000):
        watch.see(echo(1.0), Pose())
    assert watch.stuck() == {}


def test_along_a_wall_the_distance_may_stay_for_a_while() -> None:
    watch = StuckWatch()
    for step in range(25):
        watch.see(echo(0.52), Pose(0.1 * step, 0.0, 0.0))
    assert watch.stuck() == {}
    for step in range(25, 40):
        watch.see(echo(0.52), Pose(0.1 * step, 0.0, 0.0))
    assert watch.stuck() == {"front": 0.52}


def test_another_distance_or_silence_ends_it() -> None:
    watch = turned(40)
    watch.see(echo(1.001), Pose(0.0, 0.0, 4.1))
    assert watch.stuck() == {}
    watch = turned(40)
    watch.see(RangeReading(0, 0, "front", Outcome.NO_ECHO), Pose(0.0, 0.0, 4.1))
    assert watch.stuck() == {}


def test_a_turn_over_the_seam_of_angles_counts_its_way_only() -> None:
    watch = StuckWatch()
    for step in range(LEAST_READINGS):
        watch.see(echo(1.0), Pose(0.0, 0.0, pi - 0.001 if step % 2 else -pi + 0.001))
    assert watch.stuck() == {}


@given(lists(floats(0.1, 5.0), min_size=2, max_size=60, unique=True), integers(1, 20))
def test_echoes_that_change_are_never_stuck(distances: list[float], step: int) -> None:
    watch = StuckWatch()
    for number, distance in enumerate(distances):
        watch.see(echo(distance), Pose(0.0, 0.0, number * step * LEAST_TURN))
        assert watch.stuck() == {}


def test_turns_that_only_listen_do_not_hide_it() -> None:
    watch = StuckWatch()
    for step in range(40):
        listened = RangeReading(0, 0, "front", Outcome.NO_ECHO, listened=True)
        watch.see(listened if step % 5 == 0 else echo(1.0), Pose(0.0, 0.0, 0.1 * step))
    assert watch.stuck() == {"front": 1.0}


def test_each_ranger_is_watched_by_itself() -> None:
    watch = StuckWatch()
    for step in range(40):
        watch.see(echo(1.0), Pose(0.0, 0.0, 0.1 * step))
        watch.see(echo(1.0 + 0.01 * step, "rear"), Pose(0.0, 0.0, 0.1 * step))
    assert watch.stuck() == {"front": 1.0}
