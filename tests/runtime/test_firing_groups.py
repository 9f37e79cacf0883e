from itertools import combinations, pairwise
from math import pi, radians, tau

import pytest
from hypothesis import given
from hypothesis import strategies as st

from echogrid.runtime.firing_groups import Groups, angle_between, grouped

QUARTER = pi / 2
bearings = st.lists(st.integers(-360, 360).map(radians), max_size=10)
separations = st.sampled_from([30, 60, 90, 120, 180, 360]).map(radians)


def ring(count: int) -> list[float]:
    return [tau * number / count for number in range(count)]


def smallest_angle(groups: Groups, at: list[float]) -> float:
    """Between a group and the next, all around."""
    return min(
        angle_between(at[i], at[j])
        for one, other in pairwise([*groups, groups[0]])
        for i in one
        for j in other
    )


def needed(at: list[float], separation: float) -> int:
    """The fewest groups, by trying all partitions."""

    def fits(rest: list[float], groups: list[list[float]], most: int) -> bool:
        if not rest:
            return True
        for number in range(min(len(groups) + 1, most)):
            group = groups[number] if number < len(groups) else []
            if all(angle_between(rest[0], other) >= separation - 1e-9 for other in group):
                others = [*groups[:number], [*group, rest[0]], *groups[number + 1 :]]
                if fits(rest[1:], others, most):
                    return True
        return False

    return next(count for count in range(len(at) + 1) if fits(at, [], count))


@given(bearings, separations)
def test_everyone_is_in_one_group_and_two_of_a_group_are_apart(at: list[float], separation: float) -> None:
    groups = grouped(at, separation)
    assert sorted(index for group in groups for index in group) == list(range(len(at)))
    for group in groups:
        for i, j in combinations(group, 2):
            assert angle_between(at[i], at[j]) >= separation - 1e-6


@given(st.lists(st.integers(-360, 360).map(radians), max_size=7), separations)
def test_there_are_as_few_groups_as_there_can_be(at: list[float], separation: float) -> None:
    assert len(grouped(at, separation)) == needed(at, separation)


@given(bearings, separations)
def test_the_first_is_in_the_first_group_and_the_same_bearings_give_the_same(
    at: list[float], separation: float
) -> None:
    groups = grouped(at, separation)
    assert groups == grouped(at, separation)
    assert not at or 0 in groups[0]


@pytest.mark.parametrize(("count", "groups"), [(1, 1), (4, 1), (8, 2), (12, 3), (16, 4), (24, 6), (32, 8)])
def test_an_even_ring_is_put_together_evenly(count: int, groups: int) -> None:
    found = grouped(ring(count), QUARTER)
    assert len(found) == groups
    assert {len(group) for group in found} == {count // groups}


def test_no_order_of_the_groups_leaves_more_room_between_neighbours() -> None:
    at = ring(24)
    found = grouped(at, QUARTER)
    assert smallest_angle(found, at) == pytest.approx(radians(30))
    assert smallest_angle(tuple(sorted(found)), at) == pytest.approx(radians(15))


def test_one_by_one_they_fire_almost_opposite_each_other() -> None:
    found = grouped(ring(16), tau)
    assert [len(group) for group in found] == [1] * 16
    assert smallest_angle(found, ring(16)) == pytest.approx(radians(157.5))


@pytest.mark.parametrize(("one", "other", "angle"), [(0, 350, 10), (-170, 170, 20), (720, 180, 180)])
def test_angles_are_measured_the_short_way(one: float, other: float, angle: float) -> None:
    assert angle_between(radians(one), radians(other)) == pytest.approx(radians(angle))
