import sys
from dataclasses import replace
from math import radians
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from echogrid.mapping.pose import Pose
from echogrid.mapping.steering.decision import Decision
from echogrid.mapping.steering.limits import Limits
from echogrid.mapping.steering.obstacles import View
from echogrid.mapping.steering.vff import Vff
from echogrid.mapping.steering.vfh_plus import VfhPlus
from echogrid.runtime.grey_image import read_grey
from echogrid.runtime.map_picture import UNKNOWN
from echogrid.runtime.steering_picture import BLOCKED, CHOSEN, GOAL, MASKED, OPEN, made_up, main, picture

FIGURE = Path(__file__).parents[2] / "docs/figures/steering.png"


def decided() -> tuple[View, Decision]:
    view, speed, goal = made_up()
    return view, VfhPlus(view.window, Limits()).steer(view, speed, goal)


def columns(pixels: np.ndarray, colour: tuple[int, int, int]) -> list[int]:
    """Those of the histogram, from its left, that show the colour in their topmost pixel."""
    histogram = pixels[:, -72 * 6 :]
    return np.flatnonzero((histogram[0] == colour).all(axis=1)).tolist()


def shows(pixels: np.ndarray, colour: tuple[int, int, int]) -> bool:
    return bool((pixels == colour).all(axis=2).any())


def test_the_picture_shows_all_that_a_decision_is_made_of() -> None:
    pixels = picture(*decided())
    for colour in (GOAL, CHOSEN, OPEN, BLOCKED, MASKED, UNKNOWN):
        assert shows(pixels, colour)


def test_the_heading_is_drawn_to_the_left_of_the_goal_if_it_lies_there() -> None:
    view, decision = decided()
    assert decision.heading is not None
    assert decision.heading > decision.goal.bearing
    pixels = picture(view, decision)
    assert max(columns(pixels, CHOSEN)) < min(columns(pixels, GOAL))


def test_straight_ahead_is_in_the_middle_of_the_histogram() -> None:
    view, decision = decided()
    pixels = picture(view, replace(decision, heading=view.robot.yaw))
    assert abs(np.mean(columns(pixels, CHOSEN)) - 72 * 3) <= 6


def test_without_a_way_no_heading_is_drawn() -> None:
    view, decision = decided()
    assert not shows(picture(view, replace(decision, heading=None)), CHOSEN)


@given(st.floats(-4.0, 4.0), st.floats(-4.0, 4.0), st.floats(-0.024, 0.024), st.floats(0.0, 9.0))
def test_any_decision_can_be_drawn(yaw: float, heading: float, aside: float, distance: float) -> None:
    view, decision = decided()
    turned = replace(view, robot=Pose(view.robot.x, view.robot.y, yaw), offset=(aside, -aside))
    goal = replace(decision.goal, bearing=-heading, distance=distance)
    pixels = picture(turned, replace(decision, heading=heading, goal=goal))
    assert pixels.shape == picture(view, decision).shape


def test_a_method_without_thresholds_can_be_drawn_in_the_open_too() -> None:
    view, _, goal = made_up()
    empty = replace(view, hits=view.hits[:0], certainty=np.zeros_like(view.certainty))
    pixels = picture(empty, Vff().steer(empty, 0.0, goal))
    assert not shows(pixels, BLOCKED)


def test_the_made_up_robot_has_a_way_and_something_masked() -> None:
    view, decision = decided()
    assert not view.touching
    assert decision.polar.masked.any()
    assert radians(20.0) < (decision.heading or 0.0) < radians(80.0)


def test_the_figure_in_the_docs_is_what_the_command_draws(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "argv", ["steering_picture", str(tmp_path / "drawn.png")])
    main()
    assert np.array_equal(read_grey((tmp_path / "drawn.png").read_bytes()), read_grey(FIGURE.read_bytes()))
