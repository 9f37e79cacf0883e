import numpy as np
import pytest

from echogrid.mapping.pose import Pose
from echogrid.runtime import robond
from echogrid.runtime.recording import Recording
from echogrid.runtime.wall_check import score, side_walls

from .fakes import echo
from .maps import image

MS = 1_000_000


def corridor() -> Recording:
    """Ten metres along x, walls at y = -1 and y = 1.5."""
    config = robond.configuration()
    poses = [(step * 100 * MS, Pose(0.05 * step, 0.0, 0.0)) for step in range(201)]
    ranges = [
        (f"f:{step}", echo(step * 100 * MS, distance, sensor))
        for step in range(201)
        for sensor, distance in (("sonar0", 1.0), ("sonar7", 1.5))
    ]
    return Recording(config, poses, ranges)


def test_the_walls_are_where_the_side_sonars_hear_them() -> None:
    right, left = side_walls(corridor(), "sonar0", "sonar7")
    np.testing.assert_allclose(right[:, 1], -1.0, atol=1e-6)
    np.testing.assert_allclose(left[:, 1], 1.5, atol=1e-6)
    assert len(right) == len(left) == pytest.approx(101, abs=1)


def test_echoes_from_afar_and_in_turns_are_not_taken_for_walls() -> None:
    told = corridor()
    told.ranges.append(("f", echo(0, 2.6, "sonar0")))
    told.poses.append((30_000 * MS, Pose(0.0, 0.0, 0.5)))
    told.ranges.append(("f", echo(30_000 * MS, 2.0, "sonar0")))
    np.testing.assert_allclose(side_walls(told, "sonar0", "sonar7")[0][:, 1], -1.0, atol=1e-6)


@pytest.mark.parametrize(("rows", "drawn"), [((2, 27), 1.0), ((2,), 0.5), ((), 0.0)])
def test_a_wall_is_drawn_where_occupied_cells_are_near(rows: tuple[int, ...], drawn: float) -> None:
    grid = [[0.9 if row in rows else 0.1] * 120 for row in range(30)]
    made = image(grid, resolution=0.1, x=-1.0, y=-1.25)
    walls = side_walls(corridor(), "sonar0", "sonar7")
    path = np.array([[0.05 * step, 0.0] for step in range(201)])
    found = score(made, walls, path)
    assert found.drawn == pytest.approx(drawn, abs=0.02)
    assert found.path_blocked == 0.0


def test_occupied_cells_on_the_path_block_it() -> None:
    made = image([[0.9] * 120 for _ in range(30)], resolution=0.1, x=-1.0, y=-1.25)
    path = np.array([[0.05 * step, 0.0] for step in range(201)])
    assert score(made, side_walls(corridor(), "sonar0", "sonar7"), path).path_blocked == 1.0
