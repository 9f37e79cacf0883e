"""A real robot's recording: its straight walls are drawn, and only if its sensors are where they were."""

from pathlib import Path

import numpy as np
import pytest

from echogrid.runtime import offline, robond
from echogrid.runtime.wall_check import WallScore, score, side_walls

FOLDER = Path(__file__).resolve().parents[3] / "shared" / "data" / "udacity"

pytestmark = pytest.mark.skipif(not FOLDER.is_dir(), reason=f"the RoboND recording is not at {FOLDER}")


def walls_of_a_map(bearings_deg: tuple[float, ...]) -> WallScore:
    right = robond.read(FOLDER)
    path = np.array([[pose.x, pose.y] for _, pose in right.poses])
    made = offline.build(robond.read(FOLDER, robond.configuration(bearings_deg)))
    assert made.ledger.balances(0)
    return score(made.image, side_walls(right, "sonar0", "sonar7"), path)


def test_the_side_walls_are_drawn_and_the_driven_path_is_not_blocked() -> None:
    found = walls_of_a_map(robond.BEARINGS_DEG)
    assert found.drawn >= 0.90
    assert found.path_blocked <= 0.01


def test_with_the_sensor_order_mirrored_the_side_walls_are_missed() -> None:
    assert walls_of_a_map(robond.BEARINGS_DEG[::-1]).drawn < 0.20
