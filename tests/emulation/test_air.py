from dataclasses import replace
from math import cos, hypot, pi, sin

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from echogrid.emulation.air import Air
from echogrid.emulation.hearing import Outing, Ranger, scene_of
from echogrid.emulation.offices import office, office_tour
from echogrid.emulation.transducers import A02YYUW, POLAROID, SRF08, SRF235
from echogrid.emulation.walker import Walker
from echogrid.emulation.world import World

MS = 1_000_000
NOW = 5_000 * MS
EMPTY = World("empty", np.empty((0, 4)), np.empty(0, dtype=bool), np.empty((0, 3)))
WALL = replace(EMPTY, walls=np.array([(2.5, -90.0, 2.5, 90.0)]), rough=np.array([False]))
LOUD = replace(SRF08, sensitivity=90.0, reach=6.0)
"""Hears everything in its reach."""
ALL_AROUND = replace(LOUD, null_angle=9.0)
FORWARD = Ranger("forward", (0.0, 0.0, 0.0), LOUD)
TOUR = office_tour()


def still(_ns):
    return (0.0, 0.0, 0.0)


def standing(world, ranger=FORWARD, seed=None):
    """The air around a robot that stands at the origin, and what one of its rangers has around it."""
    air = Air(Outing(world, still, seed))
    return air, air.surroundings(ranger)


def crosstalk(echoes):
    return [echo.distance for echo in echoes if echo.kind == "crosstalk"]


def test_sound_that_was_sent_10_ms_before_seems_to_come_from_near():
    """On a way of 5.0 m: straight, and 3.0 m to a wall and 2.0 m from there."""
    air, ranger = standing(EMPTY)
    air.add_foreign((5.0, 0.0, pi), LOUD, [NOW - 10 * MS])
    assert crosstalk(ranger.scene(NOW)) == pytest.approx([0.7839268865871603], abs=1e-6)
    air, ranger = standing(replace(WALL, walls=np.array([(2.0, -90.0, 2.0, 90.0)])))
    air.add_foreign((-1.0, 0.0, 0.0), LOUD, [NOW - 10 * MS])
    assert crosstalk(ranger.scene(NOW)) == pytest.approx([0.7839268865871603], abs=1e-6)


def test_delays_that_differ_by_8_ms_let_crosstalk_jump():
    air, ranger = standing(EMPTY)
    air.add_foreign((5.0, 0.0, pi), LOUD, [NOW - 2 * MS, NOW + 90 * MS])
    (late,), (early,) = (crosstalk(ranger.scene(NOW + turn)) for turn in (0, 100 * MS))
    assert late - early == pytest.approx(1.3728584907302719, abs=1e-6)


@settings(deadline=None)
@given(
    st.tuples(st.floats(-2.0, 2.0), st.floats(-2.0, 2.0), st.floats(-0.9, 0.9)),
    st.integers(-30 * MS, 30 * MS),
)
def test_the_apparent_range_is_half_the_way_and_half_the_head_start(pose, later_ns):
    """By the wall at x = 2.5: the way is that from the source's image at 5 - x."""
    air, ranger = standing(WALL, replace(FORWARD, transducer=ALL_AROUND))
    air.add_foreign(pose, ALL_AROUND, [NOW + later_ns])
    way = hypot(5.0 - pose[0], pose[1])
    expected = 0.5 * way + 0.5 * air.speed_of_sound * later_ns * 1e-9
    mirrored = [distance for distance in crosstalk(ranger.scene(NOW)) if distance == pytest.approx(expected)]
    assume(abs(expected) > 1e-6 and abs(expected - LOUD.reach) > 1e-6)
    assert len(mirrored) == (0.0 <= expected <= LOUD.reach)


@settings(deadline=None)
@given(st.floats(0.3, 6.0), st.booleans())
def test_nothing_is_heard_of_a_ping_outside_of_the_window(metres, before):
    """Its sound comes in before the ranger fires, or after it has done listening."""
    air, ranger = standing(EMPTY)
    flight_ns = round(1e9 * metres / air.speed_of_sound)
    window_ns = round(2e9 * LOUD.reach / air.speed_of_sound)
    fired_ns = NOW - flight_ns - MS if before else NOW + window_ns - flight_ns + MS
    air.add_foreign((metres, 0.0, pi), LOUD, [fired_ns])
    assert ranger.scene(NOW) == ()
    assert ranger.scene(fired_ns) != ()


def test_two_rangers_of_a_robot_hear_each_other_by_a_wall():
    air = Air(Outing(WALL, still, None))
    left, right = (
        air.surroundings(Ranger(name, (0.0, y, 0.0), LOUD)) for name, y in (("left", 0.3), ("right", -0.3))
    )
    left.ping(NOW)
    right.ping(NOW)
    for ranger in (left, right):
        heard = ranger.scene(NOW)
        assert [echo.kind for echo in heard] == ["wall", "crosstalk"]
        assert heard[1].distance == pytest.approx(0.5 * hypot(5.0, 0.6))


def test_a_ranger_does_not_take_its_own_ping_for_another_s():
    _, ranger = standing(WALL)
    ranger.ping(NOW)
    assert [echo.kind for echo in ranger.scene(NOW)] == ["wall"]


def test_a_ranger_that_fires_again_too_soon_hears_its_last_ping():
    air, ranger = standing(WALL)
    ranger.ping(NOW)
    ranger.ping(NOW + 10 * MS)
    expected = 2.5 - 0.5 * air.speed_of_sound * 0.010
    assert crosstalk(ranger.scene(NOW + 10 * MS)) == pytest.approx([expected])


def test_without_an_own_ping_only_others_are_heard():
    air, ranger = standing(WALL)
    assert ranger.ambient(NOW) == ()
    air.add_foreign((2.0, 0.0, pi), LOUD, [NOW])
    assert crosstalk(ranger.ambient(NOW)) == [echo.distance for echo in ranger.ambient(NOW)]
    assert crosstalk(ranger.ambient(NOW))[0] == pytest.approx(1.0)


def test_other_frequencies_are_not_heard():
    near_by = replace(LOUD, frequency=42_000.0)
    for foreign, heard in ((LOUD, True), (near_by, True), (SRF235, False), (POLAROID, False)):
        air, ranger = standing(EMPTY)
        air.add_foreign((0.5, 0.0, pi), foreign, [NOW])
        assert bool(ranger.scene(NOW)) == heard


def test_sound_that_comes_in_while_the_gain_is_low_is_fainter():
    """Sent at the same time, 1 m is as loud as a wall at 0.5 m; sent 2 ms before, the ramp has just begun."""
    ranger = Ranger("forward", (0.0, 0.0, 0.0), A02YYUW)
    margins = []
    for before_ns in (0, 2 * MS):
        air, surroundings = standing(EMPTY, ranger)
        air.add_foreign((1.0, 0.0, pi), A02YYUW, [NOW - before_ns])
        (echo,) = surroundings.scene(NOW)
        margins.append(echo.margin)
    late = 0.5 - 0.5 * 0.002 * Air(Outing(EMPTY, still, None)).speed_of_sound
    assert margins[0] == pytest.approx(A02YYUW.sensitivity)
    assert margins[0] - margins[1] == pytest.approx(A02YYUW.way_loss(0.5) - A02YYUW.way_loss(late))


def test_a_person_keeps_the_sound_off_while_they_pass():
    """One second after the beginning they are in the way."""
    world = replace(EMPTY, walkers=(Walker(((1.0, -1.0), (1.0, 1.0)), speed=1.0),))
    air = Air(Outing(world, still, None, NOW))
    ranger = air.surroundings(FORWARD)
    times_ns = [NOW, NOW + 1_000 * MS]
    air.add_foreign((3.0, 0.0, pi), LOUD, times_ns)
    straight = [1.5 in [round(distance, 6) for distance in crosstalk(ranger.ambient(t))] for t in times_ns]
    assert straight == [True, False]


def test_the_moving_robot_hears_from_where_it_is_in_the_middle_of_its_listening():
    speed = 10.0
    air = Air(Outing(EMPTY, lambda ns: (speed * 1e-9 * (ns - NOW), 0.0, 0.0), None))
    ranger = air.surroundings(FORWARD)
    air.add_foreign((5.0, 0.0, pi), LOUD, [NOW])
    gone = speed * LOUD.reach / air.speed_of_sound
    assert crosstalk(ranger.scene(NOW)) == pytest.approx([0.5 * (5.0 - gone)], abs=1e-6)


def test_a_ping_is_sent_from_where_the_robot_was_then():
    air = Air(Outing(WALL, lambda ns: (0.0, 1.0 if ns > NOW else 0.0, 0.0), None))
    forward = air.surroundings(FORWARD)
    other = air.surroundings(Ranger("other", (0.0, 0.0, 0.0), LOUD))
    other.ping(NOW)
    assert crosstalk(forward.scene(NOW + 1)) == pytest.approx([0.5 * hypot(5.0, 1.0)], abs=1e-6)


def _ring(seed, gap_ns, transducer=SRF08):
    """What eight rangers hear that fire a gap apart, at some places of the office."""
    air = Air(Outing(office(), lambda ns: TOUR.pose(1e-9 * ns), seed))
    bearings = [index * pi / 4.0 for index in range(8)]
    rangers = [
        air.surroundings(Ranger(f"ring_{index}", (0.2 * cos(b), 0.2 * sin(b), b), transducer))
        for index, b in enumerate(bearings)
    ]
    heard = []
    for start_ns in range(0, 200_000 * MS, 10_000 * MS):
        for index, ranger in enumerate(rangers):
            ranger.ping(start_ns + index * gap_ns)
        heard += [ranger.scene(start_ns + index * gap_ns) for index, ranger in enumerate(rangers)]
    return heard


def test_the_same_seed_and_pings_give_the_same_echoes():
    assert _ring(1, 0) == _ring(1, 0)
    assert _ring(1, 0) != _ring(2, 0)


def test_crosstalk_follows_from_the_firing():
    """All at once much is heard of others; one after the other nothing is."""
    together = [echo for heard in _ring(1, 0) for echo in heard]
    apart = [echo for heard in _ring(1, 80 * MS) for echo in heard]
    assert len(crosstalk(together)) > 0.2 * len(together)
    assert crosstalk(apart) == []


def test_neighbours_change_nothing_about_the_own_echoes():
    air = Air(Outing(office(), lambda ns: TOUR.pose(1e-9 * ns), 1))
    alone = scene_of(air.outing, FORWARD)
    ranger = air.surroundings(FORWARD)
    for at_ns in range(0, 60_000 * MS, 500 * MS):
        air.add_foreign(TOUR.pose(1e-9 * at_ns), LOUD, [at_ns])
        heard = ranger.scene(at_ns)
        assert tuple(echo for echo in heard if echo.kind != "crosstalk") == alone(at_ns)
        assert [echo.distance for echo in heard] == sorted(echo.distance for echo in heard)


def test_it_remembers_no_more_than_a_second():
    air, ranger = standing(EMPTY)
    for index in range(5_000):
        ranger.ping(NOW + 10 * MS * index)
    assert len(air) <= 101


def test_noise_and_dropout_are_those_of_own_echoes():
    heard = []
    air, ranger = standing(EMPTY, replace(FORWARD, transducer=replace(LOUD, sensitivity=60.0)), 3)
    times_ns = range(NOW, NOW + 4_000 * 100 * MS, 100 * MS)
    air.add_foreign((4.0, 0.0, pi), LOUD, times_ns)
    heard = [echo.distance for at_ns in times_ns for echo in ranger.scene(at_ns)]
    assert 1.0 - len(heard) / 4_000 == pytest.approx(0.02, abs=0.007)
    assert np.std(heard) == pytest.approx(0.005 + 0.01 * 2.0, rel=0.1)
    assert np.mean(heard) == pytest.approx(2.0, abs=0.005)
