"""Near whoever moves the robot is so slow that it stands before they are there; what stands is nobody."""

from math import cos, inf, pi, sin

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pytest import approx

from echogrid.drivers.readings import Outcome, RangeReading
from echogrid.mapping.company import Company
from echogrid.mapping.placed_ping import PlacedPing
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger

MS = 1_000_000
SECOND = 1000 * MS
RADIUS = 0.22
RANGER = Ranger("ahead", Pose(), 0.26, 0.0, 6.0)
HERE = Pose()
REACTION_S, DECELERATION = 0.25, 0.8
WALKS = 0.8


def ping(now_ns: int, distance: float | None, robot: Pose = HERE) -> PlacedPing:
    outcome = Outcome.NO_ECHO if distance is None else Outcome.ECHO
    reading = RangeReading(now_ns, 0, "ahead", outcome, inf if distance is None else distance)
    return PlacedPing(reading, RANGER, robot)


def limit(company: Company, now_ns: int, robot: Pose = HERE) -> float:
    return company.limit(now_ns, robot, REACTION_S, DECELERATION)


def met(distance: float, now_ns: int = 0) -> Company:
    """Somebody who moves was heard then, so far (m) ahead of the robot's middle."""
    company = Company(RADIUS)
    company.take(ping(now_ns, distance), moves=True, strange=False)
    return company


def heard(distances: list[float | None], every_ms: int = 100) -> Company:
    """Strange echoes before a robot that stands."""
    company = Company(RADIUS)
    for step, distance in enumerate(distances):
        company.take(ping(step * every_ms * MS, distance), moves=False, strange=True)
    return company


@given(st.lists(st.floats(0.3, 4.0), max_size=30), st.integers(0, 9000))
def test_where_all_may_be_walls_nobody_is_seen_in_what_does_not_move(
    distances: list[float], later_ms: int
) -> None:
    company = Company(RADIUS)
    for step, distance in enumerate(distances):
        company.take(ping(step * 100 * MS, distance), moves=False, strange=False)
    assert limit(company, later_ms * MS) == inf


def test_who_stands_a_metre_away_is_neared_as_is_reckoned_by_hand() -> None:
    """Room 1.22 - 0.22 - 0.8 * 0.25 = 0.8 m, slope 0.25 + 0.8 / 0.8 = 1.25 s:
    v = 0.8 (sqrt(1.25^2 + 2 * 0.8 / 0.8) - 1.25)."""
    assert limit(met(1.22), 0) == approx(0.8 * (3.5625**0.5 - 1.25))
    assert limit(met(1.22), 500 * MS) == approx(0.8 * ((1.5625 + 1.0) ** 0.5 - 1.25))


@given(st.floats(0.0, 5.0), st.floats(0.0, 5.0), st.integers(0, 999))
def test_the_nearer_somebody_is_the_slower(one: float, other: float, later_ms: int) -> None:
    near, far = sorted((one, other))
    assert 0.0 <= limit(met(near), later_ms * MS) <= limit(met(far), later_ms * MS) < inf


@given(st.floats(0.0, 5.0), st.integers(0, 999), st.integers(0, 999))
def test_while_nobody_is_heard_they_may_come_nearer(away: float, one_ms: int, other_ms: int) -> None:
    company, (early, late) = met(away), sorted((one_ms, other_ms))
    assert limit(company, late * MS) <= limit(company, early * MS)


@given(st.lists(st.tuples(st.floats(0.3, 5.0), st.floats(-pi, pi)), min_size=1, max_size=6))
def test_of_several_the_one_who_can_be_there_first_counts(people: list[tuple[float, float]]) -> None:
    company = Company(RADIUS)
    for distance, bearing in people:
        company.take(ping(0, distance, Pose(0.0, 0.0, bearing)), moves=True, strange=False)
    known = limit(company, 0)
    assert known <= limit(met(people[-1][0]), 0) + 1e-9
    assert known >= limit(met(min(distance for distance, _ in people)), 0) - 1e-9


@given(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), st.floats(-pi, pi), st.floats(0.3, 3.0))
def test_where_the_robot_is_and_looks_does_not_matter(x: float, y: float, yaw: float, away: float) -> None:
    company, robot = Company(RADIUS), Pose(x, y, yaw)
    company.take(ping(0, away, robot), moves=True, strange=False)
    assert limit(company, 0, robot) == approx(limit(met(away), 0))


@given(
    st.floats(0.0, 4.0),
    st.floats(0.05, 0.8),
    st.integers(50, 600),
    st.integers(20, 100),
    st.floats(0.1, 0.25),
    st.floats(0.3, 1.0),
)
def test_who_walks_straight_at_the_robot_finds_it_standing(
    gap: float, cruise: float, ping_ms: int, tick_ms: int, reaction_s: float, deceleration: float
) -> None:
    """To 5 cm: while the limit falls, the wheels still heed the one of a reaction ago."""
    company, robot, speed = Company(RADIUS), 0.0, None
    asked: list[tuple[int, float]] = []
    for now_ms in range(20_000):
        left = gap - robot - WALKS * now_ms * 1e-3
        if left <= -0.05:
            break
        if now_ms % ping_ms == 0:
            company.take(ping(now_ms * MS, RADIUS + left, Pose(robot)), moves=True, strange=False)
        if now_ms % tick_ms == 0:
            wish = min(cruise, company.limit(now_ms * MS, Pose(robot), reaction_s, deceleration))
            asked.append((now_ms + round(reaction_s * 1e3) - tick_ms, wish))
        speed = asked[-1][1] if speed is None else braked(asked, now_ms, speed, deceleration)
        robot += speed * 1e-3
    assert left <= -0.05
    assert speed <= 0.05  # of a step: less than that is standing in trials, too


def braked(asked: list[tuple[int, float]], now_ms: int, speed: float, deceleration: float) -> float:
    """m/s a millisecond later, of wheels that are at once as quick as is asked, but not as slow."""
    wish = next((wish for due_ms, wish in reversed(asked) if due_ms <= now_ms), speed)
    return max(wish, speed - deceleration * 1e-3)


def test_who_leaves_is_forgotten_after_a_second() -> None:
    company = met(1.0)
    assert limit(company, SECOND - 1) < inf
    assert limit(company, SECOND) == inf


@given(st.lists(st.booleans(), max_size=20))
def test_silence_tells_of_nobody_and_takes_nobody_away(silences: list[bool]) -> None:
    company = met(1.0)
    for step, strange in enumerate(silences):
        company.take(ping(step * 10 * MS, None), moves=True, strange=strange)
    assert limit(company, 500 * MS) == limit(met(1.0), 500 * MS)


def test_what_appears_close_by_where_all_walls_are_known_is_somebody_at_once() -> None:
    assert limit(heard([1.0]), 0) == approx(limit(met(1.0), 0))


@pytest.mark.parametrize(("away", "counts"), [(RADIUS + 1.59, True), (RADIUS + 1.61, False)])
def test_what_appears_farther_away_must_be_seen_to_move(away: float, counts: bool) -> None:
    assert (limit(heard([away]), 0) < inf) == counts
    company = Company(RADIUS)
    company.take(ping(0, away), moves=True, strange=True)
    assert limit(company, 0) < inf


@given(st.floats(0.3, 1.3), st.integers(20, 700), st.floats(0.0, 0.19), st.integers(0, 2**16))
def test_what_was_heard_at_one_spot_for_1_3_s_is_nobody(
    away: float, every_ms: int, sways: float, pattern: int
) -> None:
    count = -(-1300 // every_ms) + 1
    swaying = [away + sways * (1 if pattern >> step % 16 & 1 else -1) for step in range(count)]
    company, stood_ms = heard([away, *swaying[1:]], every_ms), (count - 1) * every_ms
    for later_ms in range(every_ms, 14_000, every_ms):
        now_ns = (stood_ms + later_ms) * MS
        company.take(ping(now_ns, away), moves=False, strange=True)
        if later_ms >= 1000:
            assert limit(company, now_ns) == inf


def test_who_has_stood_1_2_s_still_counts() -> None:
    assert limit(heard([1.0] * 13), 1200 * MS) < inf


def test_a_pause_of_more_than_0_7_s_begins_the_standing_anew() -> None:
    broken = heard([1.0] * 7 + [None] * 7 + [1.0] * 7)
    assert limit(broken, 2000 * MS) < inf


def test_what_stood_is_still_known_15_s_later_and_then_no_more() -> None:
    for later, known in ((14_999, True), (15_000, False)):
        company = heard([1.0] * 14)
        now_ns = (1300 + later) * MS
        company.take(ping(now_ns, 1.0), moves=False, strange=True)
        assert (limit(company, now_ns) == inf) == known


def test_somebody_who_passes_before_what_stands_counts_and_it_does_not() -> None:
    company = heard([1.0] * 14)
    now_ns = 4 * SECOND
    company.take(ping(now_ns, 0.55), moves=False, strange=True)
    assert limit(company, now_ns) == approx(limit(met(0.55), 0))


def test_who_has_not_strayed_for_2_5_s_stands_even_where_walls_are_unknown() -> None:
    company = met(1.0)
    for step in range(1, 30):
        company.take(ping(step * 100 * MS, 1.0 + 0.02 * (step % 2)), moves=False, strange=False)
        assert (limit(company, step * 100 * MS) == inf) == (step >= 25)


@given(st.floats(-pi, pi), st.integers(50, 500))
def test_who_walks_on_counts_as_long_as_they_are_heard_once_a_second(bearing: float, every_ms: int) -> None:
    company = Company(RADIUS)
    for step in range(12_000 // every_ms):
        way = WALKS * step * every_ms * 1e-3
        there = Pose(0.3 + way * cos(bearing), way * sin(bearing))
        company.take(ping(step * every_ms * MS, 0.0, there), moves=step == 0, strange=False)
        assert limit(company, step * every_ms * MS, there.compose(Pose(1.0))) < inf
