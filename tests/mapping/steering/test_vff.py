from math import pi

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.steering.decision import Why
from echogrid.mapping.steering.goal import Goal
from echogrid.mapping.steering.vff import Vff, VffForces

from .scenes import MIDDLE, view_of


def test_a_push_that_equals_the_pull_leaves_no_direction() -> None:
    """A sure cell at 1 m straight ahead pushes with 15 F_cr."""
    decision = Vff(VffForces(repulsion=1.0 / 15.0)).steer(view_of([(0, 10, 2000)]), 0.0, Goal(0.0))
    assert (decision.heading, decision.why) == (None, Why.BALANCED)


@given(st.integers(3, 15), st.floats(0.01, 0.1))
def test_an_obstacle_on_the_left_pushes_to_the_right(away: int, repulsion: float) -> None:
    decision = Vff(VffForces(repulsion)).steer(view_of([(away, 0, 2000)], MIDDLE), 0.0, Goal(0.0))
    assert decision.heading is not None
    assert -pi / 2.0 < decision.heading < 0.0


@pytest.mark.parametrize("certainty", [1000, 2000])
def test_a_push_falls_with_the_square_of_the_distance(certainty: int) -> None:
    def push(away: int) -> float:
        return float(Vff().steer(view_of([(away, 0, certainty)]), 0.0, Goal(0.0)).polar.density.sum())

    assert push(5) == approx(4.0 * push(10))
