from math import cos, hypot, pi, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.footprint import Footprint

from .outlines import ELL, TEE, outlines

points = st.tuples(st.floats(-2.0, 2.0), st.floats(-2.0, 2.0))


def distance(outline: Footprint, x: float, y: float) -> float:
    return float(outline.distance(np.array([x]), np.array([y]))[0])


def winding(outline: Footprint, x: float, y: float) -> int:
    """How often the outline goes round a point: the sum of the angles under which its sides are seen."""
    corners = np.array([complex(*corner) for corner in outline.corners]) - complex(x, y)
    return round(float(np.angle(np.roll(corners, -1) / corners).sum()) / (2.0 * pi))


def walked(outline: Footprint, x: float, y: float) -> float:
    """The distance to the nearest of points close together on the outline."""
    ends = zip(outline.corners, (*outline.corners[1:], outline.corners[0]), strict=True)
    part = np.linspace(0.0, 1.0, 2001)
    return min(
        float(np.hypot(a[0] + part * (b[0] - a[0]) - x, a[1] + part * (b[1] - a[1]) - y).min())
        for a, b in ends
    )


@given(outlines, points)
def test_the_distance_is_that_of_the_nearest_point_of_the_outline_and_nothing_within(
    outline: Footprint, point: tuple[float, float]
) -> None:
    near = walked(outline, *point)
    if near > 1e-3:
        expected = 0.0 if winding(outline, *point) else near
        assert distance(outline, *point) == approx(expected, abs=1e-3)


@given(outlines, points)
def test_it_does_not_matter_which_way_round_the_corners_are_told(
    outline: Footprint, point: tuple[float, float]
) -> None:
    assert distance(Footprint(outline.corners[::-1]), *point) == approx(distance(outline, *point), abs=1e-9)


@given(st.integers(12, 64), st.floats(0.02, 1.0), st.floats(0.0, 2.0 * pi), st.floats(0.0, 0.2))
def test_round_is_who_comes_nearer_to_nothing_when_it_turns_in_place(
    corners: int, radius: float, turn: float, aside: float
) -> None:
    around = [turn + 2.0 * pi * k / corners for k in range(corners)]
    disc = Footprint([(radius * cos(a) + aside, radius * sin(a)) for a in around])
    turned = [disc.distance(2.0 * np.cos([a]), 2.0 * np.sin([a]))[0] for a in np.linspace(0.0, 2.0 * pi, 500)]
    assert disc.is_round or max(turned) - min(turned) > 0.009
    assert not disc.is_round or max(turned) - min(turned) < 0.011


def test_a_box_is_not_round_and_neither_is_what_lies_beside_base_link() -> None:
    assert not Footprint.box(-0.1, 0.1, 0.1).is_round
    assert not Footprint.box(0.6, 0.601, 0.002).is_round


def test_a_box_and_its_reach() -> None:
    box = Footprint.box(-0.1, 0.3, 0.2)
    assert distance(box, 0.5, 0.0) == approx(0.2)
    assert distance(box, 0.6, 0.6) == approx(0.5)
    assert distance(box, 0.0, 0.1) == 0.0
    assert box.reach == approx(hypot(0.3, 0.2))


def test_what_is_between_the_arms_is_outside() -> None:
    assert distance(ELL, 0.2, 0.15) > 0.0
    assert distance(TEE, 0.0, 0.0) == 0.0


@pytest.mark.parametrize(
    ("corners", "why"),
    [
        ([(0, 0), (1, 0)], "3...64 corners, not 2"),
        ([(cos(k), sin(k)) for k in np.linspace(0, 6, 65)], "not 65"),
        ([(0, 0), (0, 0), (1, 1)], "one point"),
        ([(0, 0), (1, 1), (1, 0), (0, 1)], "crosses itself: side 1 meets side 3"),
        ([(0, 0), (2, 0), (1, 0)], "crosses itself"),
        ([(0, 0), (1, 0), (2, 0)], "crosses itself"),
        ([(0, 0), (2, 0), (2, 2), (1, 0), (0, 2)], "crosses itself"),
    ],
)
def test_what_is_no_outline_is_refused(corners: list[tuple[float, float]], why: str) -> None:
    with pytest.raises(ValueError, match=why):
        Footprint(corners)
