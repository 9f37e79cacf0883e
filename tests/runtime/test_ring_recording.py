from functools import cache
from itertools import pairwise
from math import degrees, hypot

import pytest

from echogrid.emulation.worlds import WORLDS, Venue
from echogrid.mapping.pose import wrap_angle
from echogrid.runtime.acoustics_check import REACH_M, RING_RADIUS_M, SONARS
from echogrid.runtime.loop import SECOND_NS
from echogrid.runtime.ring_recording import GAP_NS, NEAREST_M, RingPing, record, soundings


@cache
def lap(world: str, seed: int) -> tuple[RingPing, ...]:
    return tuple(record(WORLDS[world](), seed))


def venue() -> Venue:
    return WORLDS["foyer"]()


def test_a_world_and_a_seed_give_the_same_pings() -> None:
    assert soundings(venue(), 3) == [ping.sounding for ping in lap("foyer", 3)]


def test_another_seed_gives_others() -> None:
    one, other = ([ping.sounding.echo for ping in lap("foyer", seed)] for seed in (3, 4))
    assert len(one) == pytest.approx(len(other), abs=50)
    assert one != other


def test_the_ring_pings_all_the_way_round_once() -> None:
    tour, pings = venue().tour, lap("foyer", 3)
    assert len(pings) == pytest.approx(tour.lap_time / (GAP_NS / SECOND_NS), rel=0.01)
    assert pings[-1].sounding.stamp_ns / SECOND_NS == pytest.approx(tour.lap_time, abs=0.1)


def test_sixteen_pings_one_after_the_other_come_from_all_sonars_and_no_neighbours() -> None:
    names = [ping.sounding.ranger.name for ping in lap("foyer", 3)[:200]]
    assert len(set(names)) == SONARS
    for before, after in pairwise(names):
        one, other = (int(name.removeprefix("ring_")) for name in (before, after))
        assert min((one - other) % SONARS, (other - one) % SONARS) >= 4


def test_an_echo_lies_between_blanking_and_reach_and_silence_is_none() -> None:
    echoes = [ping.sounding.echo for ping in lap("foyer", 3)]
    assert None in echoes
    assert all(NEAREST_M <= echo < REACH_M for echo in echoes if echo is not None)


def test_the_transducer_is_where_the_tour_has_it_at_the_stamp() -> None:
    tour = venue().tour
    for ping in lap("foyer", 3)[::97]:
        x, y, yaw = tour.pose(ping.sounding.stamp_ns / SECOND_NS)
        seat, mount = ping.sounding.transducer, ping.sounding.ranger.mount
        assert hypot(seat.x - x, seat.y - y) == pytest.approx(RING_RADIUS_M)
        assert degrees(wrap_angle(seat.yaw - yaw - mount.yaw)) == pytest.approx(0.0, abs=1e-6)


def test_a_ping_knows_how_fast_the_robot_was() -> None:
    speeds = [ping.speed for ping in lap("foyer", 3)]
    assert min(speeds) == pytest.approx(0.0, abs=0.01)
    assert max(speeds) == pytest.approx(0.4)


def test_the_sound_meets_the_obstacle_after_the_ping_and_before_the_next() -> None:
    for number, ping in enumerate(lap("museum", 0)[:500]):
        flight_ns = ping.sounding.stamp_ns % GAP_NS
        assert 0 < flight_ns < GAP_NS // 2, number
