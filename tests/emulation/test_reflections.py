from dataclasses import replace
from math import atan2, cos, degrees, hypot, inf, pi, radians, sin

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from echogrid.emulation.offices import office, office_tour
from echogrid.emulation.reflections import echoes
from echogrid.emulation.transducers import POLAROID, SRF08
from echogrid.emulation.world import World

from .ray_fan import beam, hits, nearest_hit, shortest_way

WALL = ((2.0, -20.0, 2.0, 20.0),)
OFFICE = office()
TOUR = office_tour()
tour_times = st.floats(0.0, TOUR.lap_time)
bearings = st.floats(-pi, pi)


def world_of(walls=(), cylinders=(), rough=()):
    flags = np.array([index in rough for index in range(len(walls))], dtype=bool)
    return World("test", np.array(walls).reshape(-1, 4), flags, np.array(cylinders).reshape(-1, 3))


def nearest(world, pose, transducer=POLAROID):
    heard = echoes(world, pose, transducer)
    return heard[0] if heard else None


@pytest.mark.parametrize(("off_axis", "level"), [(0.0, 0.0), (5.0, -5.34), (10.0, -21.37)])
def test_a_wall_at_2_m_grows_faint_off_the_axis(off_axis, level):
    (echo,) = echoes(world_of(WALL), (0.0, 0.0, radians(off_axis)), POLAROID)
    assert echo.kind == "wall"
    assert echo.distance == pytest.approx(2.0, abs=1e-9)
    assert echo.margin - POLAROID.sensitivity == pytest.approx(level, abs=0.005)


@pytest.mark.parametrize(("off_axis", "level"), [(11.85, -30.01), (13.0, -36.12)])
def test_a_wall_beyond_the_visible_angle_gives_no_echo(off_axis, level):
    pose = (0.0, 0.0, radians(off_axis))
    assert echoes(world_of(WALL), pose, POLAROID) == ()
    (faint,) = echoes(world_of(WALL), pose, replace(POLAROID, sensitivity=40.0))
    assert faint.margin - 40.0 == pytest.approx(level, abs=0.02)


@settings(deadline=None)
@given(st.floats(0.3, 8.0), st.floats(0.0, 1.5))
def test_a_wall_is_heard_up_to_the_visible_angle_and_not_beyond(distance, slant):
    world = world_of(((distance, -90.0, distance, 90.0),))
    heard = echoes(world, (0.0, 0.0, slant), POLAROID)
    assert bool(heard) == (slant <= POLAROID.beam_half_width)


STEP = radians(0.1)


@settings(deadline=None)
@given(tour_times, bearings, st.sampled_from([POLAROID, SRF08]))
def test_no_wall_or_cylinder_is_heard_nearer_than_the_nearest_ray_hit(t_s, bearing, transducer):
    pose = (*TOUR.pose(t_s)[:2], bearing)
    headings = beam(bearing, 1.1 * transducer.beam_half_width, STEP)
    nearest_ray = hits(OFFICE, pose[:2], headings).min()
    for echo in echoes(OFFICE, pose, transducer):
        if echo.kind in ("wall", "cylinder"):
            assert echo.distance >= nearest_ray - 0.002


@settings(deadline=None)
@given(tour_times, bearings)
def test_no_direct_echo_is_nearer_than_the_shortest_way(t_s, bearing):
    pose = (*TOUR.pose(t_s)[:2], bearing)
    for echo in echoes(OFFICE, pose, SRF08):
        assert echo.distance >= shortest_way(OFFICE, pose[:2]) - 1e-9


SMOOTH = np.append(~OFFICE.rough, np.ones(len(OFFICE.cylinders), dtype=bool))


@settings(deadline=None)
@given(tour_times, bearings, st.floats(-0.15, 0.15))
def test_the_fans_minimum_is_heard_where_it_is_square_to_a_smooth_surface(t_s, heading, off_axis):
    """Aims about square at a surface in sight; counts if the minimum of the fan is there, and inside it."""
    place = TOUR.pose(t_s)[:2]
    surface = int(hits(OFFICE, place, np.array([heading])).argmin())
    bearing = _square_to(surface, place) + off_axis
    found = hits(OFFICE, place, beam(bearing, POLAROID.beam_half_width, STEP))
    ray, struck = np.unravel_index(found.argmin(), found.shape)
    assume(struck == surface and SMOOTH[surface])
    assume(abs(found[ray, struck] - _height_over(surface, place)) < 1e-4)
    loud = replace(POLAROID, sensitivity=POLAROID.sensitivity + 30.0 * (surface >= len(OFFICE.walls)))
    assert any(
        echo.distance == pytest.approx(found[ray, struck], abs=1e-4)
        for echo in echoes(OFFICE, (*place, bearing), loud)
    )


def _square_to(surface, place):
    """Heading from a place to the foot on a wall's line, or to the centre of a cylinder."""
    if surface >= len(OFFICE.walls):
        cx, cy, _ = OFFICE.cylinders[surface - len(OFFICE.walls)]
        return atan2(cy - place[1], cx - place[0])
    ax, ay, bx, by = OFFICE.walls[surface]
    normal = atan2(ax - bx, by - ay)
    towards = (ax - place[0]) * cos(normal) + (ay - place[1]) * sin(normal)
    return normal if towards > 0.0 else normal + pi


def _height_over(surface, place):
    """Shortest distance from a place to a wall's line, or to a cylinder."""
    if surface >= len(OFFICE.walls):
        cx, cy, radius = OFFICE.cylinders[surface - len(OFFICE.walls)]
        return hypot(cx - place[0], cy - place[1]) - radius
    ax, ay = OFFICE.walls[surface][:2]
    normal = _square_to(surface, place)
    return (ax - place[0]) * cos(normal) + (ay - place[1]) * sin(normal)


@settings(deadline=None)
@given(st.floats(1.0, 9.0), st.floats(-0.15, 0.15), st.floats(0.05, 0.5))
def test_a_cylinder_answers_from_its_nearest_point(distance, bearing, radius):
    centre = (distance * cos(bearing), distance * sin(bearing))
    world = world_of(cylinders=((*centre, radius),))
    echo = nearest(world, (0.0, 0.0, 0.0), replace(POLAROID, sensitivity=60.0))
    assert echo.kind == "cylinder"
    assert echo.distance == pytest.approx(nearest_hit(world, (0.0, 0.0), bearing))


CORNER = ((2.0, -1.0, 2.0, 1.0), (2.0, 1.0, 0.0, 1.0))


@settings(deadline=None)
@given(st.floats(-0.9, 1.7), st.floats(-0.9, 0.8))
def test_a_corner_is_heard_from_its_vertex_at_any_incidence(x, y):
    towards = atan2(1.0 - y, 2.0 - x)
    heard = echoes(world_of(CORNER), (x, y, towards), POLAROID)
    corners = [echo.distance for echo in heard if echo.kind == "corner"]
    assert corners == pytest.approx([hypot(2.0 - x, 1.0 - y)])


@settings(deadline=None)
@given(st.floats(2.15, 4.0), st.floats(1.1, 4.0))
def test_from_behind_a_corner_is_an_edge(x, y):
    towards = atan2(1.0 - y, 2.0 - x)
    heard = echoes(world_of(CORNER), (x, y, towards), POLAROID)
    assert {echo.kind for echo in heard} == {"edge"}
    assert heard[0].margin == pytest.approx(10.0 - 10.0 * np.log10(hypot(x - 2.0, y - 1.0)))


def test_the_end_of_a_screen_is_heard_as_an_edge():
    echo = nearest(world_of(((1.0, 0.0, 3.0, 0.0),)), (0.0, 0.0, 0.0))
    assert (echo.kind, echo.distance) == ("edge", pytest.approx(1.0))


def test_a_rough_wall_is_heard_at_a_slant_at_which_a_smooth_one_is_not():
    slanted = (0.0, 0.0, radians(14.0))
    assert echoes(world_of(WALL), slanted, POLAROID) == ()
    echo = nearest(world_of(WALL, rough={0}), slanted)
    assert echo.kind == "rough"
    assert 2.0 <= echo.distance <= 2.0 / cos(radians(26.0))


@settings(deadline=None, max_examples=30)
@given(tour_times, bearings)
def test_nothing_behind_an_occluder_answers(t_s, bearing):
    """A small pen around the sensor hides the whole office."""
    x, y, _ = TOUR.pose(t_s)
    pen = ((x - 0.2, y - 0.2, x + 0.2, y - 0.2), (x + 0.2, y - 0.2, x + 0.2, y + 0.2))
    pen += ((x + 0.2, y + 0.2, x - 0.2, y + 0.2), (x - 0.2, y + 0.2, x - 0.2, y - 0.2))
    rough = np.concatenate((OFFICE.rough, np.zeros(4, dtype=bool)))
    world = replace(OFFICE, walls=np.concatenate((OFFICE.walls, np.array(pen))), rough=rough)
    for echo in echoes(world, (x, y, bearing), replace(POLAROID, blanking=0.0)):
        assert echo.distance <= 0.2 * 2**0.5 + 1e-9 or echo.kind == "bounce"
        assert echo.distance <= 3 * 0.4 * 2**0.5 + 1e-9


def test_a_cylinder_hides_what_stands_behind_it():
    world = world_of(WALL, cylinders=((1.0, 0.0, 0.2),))
    assert [echo.kind for echo in echoes(world, (0.0, 0.0, 0.0), POLAROID)] == ["cylinder"]


@settings(deadline=None)
@given(st.floats(0.2, 4.0), st.floats(1.0, 15.0), st.floats(-0.2, 0.2), st.sampled_from([POLAROID, SRF08]))
def test_a_soft_wall_is_heard_less_than_a_hard_one_at_every_distance(distance, softness, slant, transducer):
    hard = world_of(((distance, -90.0, distance, 90.0),))
    loud = replace(transducer, sensitivity=90.0)
    (before,) = echoes(hard, (0.0, 0.0, slant), loud)
    (after,) = echoes(replace(hard, wall_softness=np.array([softness])), (0.0, 0.0, slant), loud)
    assert before.margin - after.margin == pytest.approx(softness)
    assert after.distance == before.distance


def test_soft_posts_and_soft_rough_walls_return_less_too():
    post, brick = world_of(cylinders=((2.0, 0.0, 0.3),)), world_of(WALL, rough={0})
    pouf = replace(post, cylinder_softness=np.array([12.0]))
    curtain = replace(brick, wall_softness=np.array([12.0]))
    loud = replace(POLAROID, sensitivity=60.0)
    for hard, soft in ((post, pouf), (brick, curtain)):
        before, after = (echoes(world, (0.0, 0.0, 0.0), loud) for world in (hard, soft))
        assert before[0].margin - after[0].margin == pytest.approx(12.0)


def test_a_soft_mirror_takes_from_the_sound_that_it_turns():
    world = world_of(((1.5, -0.5, 2.5, 0.5), (1.0, 3.0, 3.0, 3.0)))
    softened = replace(world, wall_softness=np.array([11.0, 0.0]))
    (echo,) = echoes(softened, (0.0, 0.0, 0.0), POLAROID)
    assert (echo.kind, echo.margin) == ("bounce", pytest.approx(POLAROID.sensitivity - 4.0 - 11.0))


def _moved(world, turn, shift, mirror=1.0):
    """The world mirrored at the x axis if asked to, then turned, then shifted."""
    matrix = np.array(((cos(turn), -sin(turn)), (sin(turn), cos(turn)))) @ np.diag((1.0, mirror))
    ends = world.walls.reshape(-1, 2) @ matrix.T + shift
    posts = np.column_stack((world.cylinders[:, :2] @ matrix.T + shift, world.cylinders[:, 2]))
    return replace(world, walls=ends.reshape(-1, 4), cylinders=posts), matrix


def _loud(heard):
    """Those which rounding cannot push over the threshold, nearest first."""
    return sorted((round(echo.distance, 6), echo.kind) for echo in heard if echo.margin > 1e-6)


@settings(deadline=None, max_examples=40)
@given(tour_times, bearings, st.floats(-3.0, 3.0), st.floats(-9.0, 9.0), st.sampled_from([1.0, -1.0]))
def test_moving_or_mirroring_world_and_sensor_together_changes_nothing(t_s, bearing, turn, shift, mirror):
    x, y, _ = TOUR.pose(t_s)
    x, y = x + 0.00123, y + 0.00071  # from a way point the foot on a wall may be its very end
    world, matrix = _moved(OFFICE, turn, (shift, -0.5 * shift), mirror)
    moved_x, moved_y = matrix @ (x, y) + (shift, -0.5 * shift)
    before = echoes(OFFICE, (x, y, bearing), POLAROID)
    after = echoes(world, (moved_x, moved_y, turn + mirror * bearing), POLAROID)
    assert [distance for distance, _ in _loud(after)] == pytest.approx(
        [distance for distance, _ in _loud(before)], abs=2e-6
    )


def test_one_mirror_turns_the_sound_to_the_next_wall():
    """Under 45 deg to one wall, square to another after it: 2 m to the mirror and 3 m on."""
    mirror = (1.5, -0.5, 2.5, 0.5)
    world = world_of((mirror, (1.0, 3.0, 3.0, 3.0)))
    (echo,) = echoes(world, (0.0, 0.0, 0.0), POLAROID)
    assert echo.kind == "bounce"
    assert echo.distance == pytest.approx(5.0)
    assert echo.margin == pytest.approx(POLAROID.sensitivity - 4.0)


def test_two_mirrors_turn_the_sound_twice():
    mirrors = ((1.5, -0.5, 2.5, 0.5), (1.5, 2.5, 2.5, 3.5))
    world = world_of((*mirrors, (4.0, 2.5, 4.0, 3.5)))
    (echo,) = echoes(world, (0.0, 0.0, 0.0), POLAROID)
    assert echo.kind == "bounce"
    assert echo.distance == pytest.approx(7.0)
    assert echo.margin == pytest.approx(POLAROID.sensitivity - 8.0)


def test_a_rough_wall_is_no_mirror():
    world = world_of(((1.5, -0.5, 2.5, 0.5), (1.0, 3.0, 3.0, 3.0)), rough={0})
    assert {echo.kind for echo in echoes(world, (0.0, 0.0, 0.0), POLAROID)} == {"rough"}


def test_nothing_is_heard_in_the_open_or_inside_the_blanking():
    assert echoes(world_of(), (0.0, 0.0, 0.0), POLAROID) == ()
    assert echoes(world_of(WALL), (1.9, 0.0, 0.0), POLAROID) == ()
    assert echoes(world_of(((11.0, -9.0, 11.0, 9.0),)), (0.0, 0.0, 0.0), POLAROID) == ()


def test_noise_is_as_wide_as_stated_and_two_pings_in_a_hundred_are_lost():
    rng = np.random.default_rng(3)
    pings = [echoes(world_of(WALL), (0.0, 0.0, 0.0), POLAROID, rng) for _ in range(4000)]
    ranges = np.array([heard[0].distance for heard in pings if heard])
    margins = np.array([heard[0].margin for heard in pings if heard])
    assert 1.0 - len(ranges) / 4000 == pytest.approx(0.02, abs=0.007)
    assert ranges.std() == pytest.approx(0.025, rel=0.1)
    assert ranges.mean() == pytest.approx(2.0, abs=0.003)
    assert margins.std() == pytest.approx(2.0, rel=0.1)


def test_the_office_is_as_deceptive_as_real_corridors_are():
    """Of sixteen Polaroids which listen to 5 m, over the round."""
    transducer = replace(POLAROID, reach=5.0)
    rng = np.random.default_rng(1)
    first = []
    for t_s in np.arange(0.0, TOUR.lap_time, 4.1):
        x, y, yaw = TOUR.pose(t_s)
        for bearing in yaw + np.arange(16) * (pi / 8):
            place = (x + 0.25 * cos(bearing), y + 0.25 * sin(bearing), bearing)
            heard = echoes(OFFICE, place, transducer, rng)
            first.append(heard[0].kind if heard else "none")
    assert 0.33 <= first.count("none") / len(first) <= 0.55
    assert 0.03 <= first.count("bounce") / len(first) <= 0.10


def test_echoes_come_nearest_first_and_are_all_above_the_threshold():
    for t_s in range(0, 300, 7):
        heard = echoes(OFFICE, TOUR.pose(t_s), SRF08)
        assert [echo.distance for echo in heard] == sorted(echo.distance for echo in heard)
        assert all(echo.margin >= 0.0 and echo.distance < inf for echo in heard)


def test_the_visible_angle_of_a_polaroid_is_the_published_one():
    assert degrees(POLAROID.beam_half_width) == pytest.approx(11.85, abs=0.01)
