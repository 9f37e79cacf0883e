import sys
from dataclasses import replace
from math import inf, pi, radians
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
from echogrid.mapping.virtual_sensor import SectorState
from echogrid.runtime.grey_image import read_grey
from echogrid.runtime.map_picture import UNKNOWN
from echogrid.runtime.polar_picture import THRESHOLD
from echogrid.runtime.steering_picture import made_up, main, panel, picture
from echogrid.runtime.steering_window import BLOCKED, CHOSEN, GOAL, MASKED, NEAREST, OPEN, STALE

FIGURE = Path(__file__).parents[2] / "docs/figures/steering.png"


SECTORS = made_up().sectors


def decided() -> tuple[View, Decision]:
    scene = made_up()
    method = VfhPlus(scene.view.window, Limits())
    return scene.view, method.steer(scene.view, scene.speed, scene.goal)


def columns(pixels: np.ndarray, colour: tuple[int, int, int]) -> list[int]:
    """Those of the histogram, from its left, that show the colour in their topmost pixel."""
    histogram = pixels[:, -72 * 6 :]
    return np.flatnonzero((histogram[0] == colour).all(axis=1)).tolist()


def shows(pixels: np.ndarray, colour: tuple[int, int, int]) -> bool:
    return bool((pixels == colour).all(axis=2).any())


def test_the_picture_shows_all_that_a_decision_is_made_of() -> None:
    for draw in (picture, panel):
        pixels = draw(*decided(), SECTORS)
        for colour in (GOAL, CHOSEN, OPEN, BLOCKED, MASKED, UNKNOWN, NEAREST, THRESHOLD):
            assert shows(pixels, colour)


def ring(pixels: np.ndarray, bearing: float) -> tuple[int, ...]:
    """The colour of the ring around the window in that direction."""
    middle = len(pixels) / 2.0
    away = middle - 4.0
    row, col = middle - away * np.sin(bearing), middle + away * np.cos(bearing)
    return tuple(pixels[int(row), int(col)].tolist())


def test_the_ring_tells_the_state_of_each_sector_in_its_direction() -> None:
    view, decision = decided()
    colours = {"clear": OPEN, "blocked": BLOCKED, "unknown": UNKNOWN, "stale": STALE}
    stale = (replace(SECTORS[0], state=SectorState.STALE), *SECTORS[1:])
    for sectors in (SECTORS, stale):
        pixels = picture(view, decision, sectors)
        for sector in sectors:
            assert ring(pixels, view.robot.yaw + sector.bearing) == colours[sector.state.value]


def test_an_obstacle_of_a_sector_is_an_arc_at_its_distance() -> None:
    view, decision = decided()
    cleared = [replace(sector, state=SectorState.CLEAR, nearest=inf) for sector in SECTORS]
    assert not shows(picture(view, decision, cleared), NEAREST)
    cleared[0] = replace(cleared[0], state=SectorState.BLOCKED, nearest=0.8)
    pixels = picture(view, decision, cleared)[:, :426]
    rows, cols = np.nonzero((pixels == NEAREST).all(axis=2))
    x, y = (cols - 213.0) / 120.0 - view.offset[0], (213.0 - rows) / 120.0 - view.offset[1]
    np.testing.assert_allclose(np.hypot(x, y), 0.8, atol=0.03)
    off = np.arctan2(y, x) - view.robot.yaw
    assert np.abs(off).max() < pi / 16.0
    assert abs(off.mean()) < 0.03


def test_without_sectors_there_is_no_ring() -> None:
    view, decision = decided()
    assert ring(picture(view, decision, ()), 0.0) == (255, 255, 255)


def test_the_heading_is_drawn_to_the_left_of_the_goal_if_it_lies_there() -> None:
    view, decision = decided()
    assert decision.heading is not None
    assert decision.heading > decision.goal.bearing
    pixels = picture(view, decision, SECTORS)
    assert max(columns(pixels, CHOSEN)) < min(columns(pixels, GOAL))


def test_straight_ahead_is_in_the_middle_of_the_histogram() -> None:
    view, decision = decided()
    pixels = picture(view, replace(decision, heading=view.robot.yaw), SECTORS)
    assert abs(np.mean(columns(pixels, CHOSEN)) - 72 * 3) <= 6


def test_without_a_way_no_heading_is_drawn() -> None:
    view, decision = decided()
    assert not shows(picture(view, replace(decision, heading=None), SECTORS), CHOSEN)


@given(st.floats(-4.0, 4.0), st.floats(-4.0, 4.0), st.floats(-0.024, 0.024), st.floats(0.0, 9.0))
def test_any_decision_can_be_drawn(yaw: float, heading: float, aside: float, distance: float) -> None:
    view, decision = decided()
    turned = replace(view, robot=Pose(view.robot.x, view.robot.y, yaw), offset=(aside, -aside))
    goal = replace(decision.goal, bearing=-heading, distance=distance)
    turn = replace(decision, heading=heading, goal=goal)
    for draw in (picture, panel):
        assert draw(turned, turn, SECTORS).shape == draw(view, decision, SECTORS).shape


def test_a_method_without_thresholds_can_be_drawn_in_the_open_too() -> None:
    scene = made_up()
    view = scene.view
    empty = replace(view, hits=view.hits[:0], certainty=np.zeros_like(view.certainty))
    pixels = picture(empty, Vff().steer(empty, 0.0, scene.goal), ())
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
