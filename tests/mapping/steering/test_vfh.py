from math import pi, tau

import numpy as np
import pytest
from hypothesis import given
from pytest import approx

from echogrid.mapping.pose import wrap_angle
from echogrid.mapping.steering.decision import Decision, Why
from echogrid.mapping.steering.goal import Goal
from echogrid.mapping.steering.vfh import Vfh, VfhNumbers, smoothed

from .scenes import WINDOW, Cell, facing, headings, view_of, worlds

ALPHA = tau / 72.0


def wall(columns: range, rows: range) -> list[Cell]:
    return [(row, col, 2000) for row in rows for col in columns]


@given(worlds, headings, headings)
def test_the_chosen_direction_is_not_blocked(world: list[Cell], yaw: float, bearing: float) -> None:
    decision = Vfh(WINDOW).steer(view_of(world, facing(yaw)), 0.0, Goal(bearing))
    if decision.heading is None:
        assert decision.why is Why.TOUCHING or decision.polar.blocked.all()
        return
    chosen = decision.candidates[0].sector
    assert not decision.polar.blocked[round(chosen - 0.25) % 72]
    assert not decision.polar.blocked[round(chosen + 0.25) % 72]


def test_a_goal_behind_a_block_is_passed_half_of_s_max_beside_it() -> None:
    decision = Vfh(WINDOW).steer(view_of(wall(range(7, 9), range(-2, 3))), 0.0, Goal(0.05))
    blocked = np.flatnonzero(decision.polar.blocked)
    border = int(blocked[blocked < 36].max()) + 1
    assert decision.heading == approx((border + 9 + 0.5) * ALPHA)
    assert decision.why is Why.AROUND


def test_a_narrow_valley_is_taken_in_its_middle() -> None:
    """Walls to the left and right of a gap that is less than s_max wide."""
    world = wall(range(4, 9), range(7, 9)) + wall(range(4, 9), range(-8, -6))
    world += (
        wall(range(-9, 4), range(7, 9))
        + wall(range(-9, 4), range(-8, -6))
        + wall(range(-9, -7), range(-8, 9))
    )
    decision = Vfh(WINDOW).steer(view_of(world), 0.0, Goal(0.2))
    free = np.flatnonzero(~decision.polar.blocked)
    turns = [wrap_angle((k + 0.5) * ALPHA) for k in free]
    assert len(free) < 18
    assert decision.heading == approx((min(turns) + max(turns)) / 2.0)


def test_it_slows_down_with_the_density_where_it_drives_now() -> None:
    def facing_a_block(certainty_milli: int) -> Decision:
        return Vfh(WINDOW).steer(view_of([(0, 10, certainty_milli)]), 0.0, Goal(pi / 2.0))

    clear, some, much = (facing_a_block(milli).factor for milli in (-2000, 1000, 2000))
    assert clear == 1.0
    assert 1.0 > some > much > 0.0


def test_smoothing_by_nothing_changes_nothing() -> None:
    density = np.arange(72.0)
    assert smoothed(density, 0).tolist() == density.tolist()


@pytest.mark.parametrize(("distance", "cells"), [(0.7, 7.0), (1.2, 12.0), (9.0, 16.0)])
def test_the_threshold_is_what_three_sure_cells_of_10_cm_leave_in_the_middle_of_their_sector(
    distance: float, cells: float
) -> None:
    """At the distance that blocks, or at the window's border."""
    expected = 3.0 * 15**2 * (2.0**0.5 * 16.0 - cells) * 6.0 / 11.0
    assert Vfh(WINDOW, VfhNumbers(blocking=distance)).threshold == approx(expected)
