from dataclasses import replace

import pytest
from pytest import approx

from echogrid.runtime import assembly, robot_file
from echogrid.runtime.config import Config
from echogrid.runtime.emulated import DEFAULT_ROBOT
from echogrid.runtime.errors import ConfigError
from echogrid.runtime.hardware_config import RobotConfig, SensorConfig
from echogrid.runtime.hull import footprint

from .test_fusion import CONFIG

FRONT = SensorConfig("front", 0.3, 0.1, 0.0, 15.0, 0.1, 2.0)


def bounds(config: Config) -> tuple[float, float, float]:
    outline = footprint(config)
    return float(outline.x.min()), float(outline.x.max()), float(outline.y.max())


def test_without_an_outline_it_is_the_box_around_wheels_and_rangers() -> None:
    config = Config(RobotConfig(wheel_radius_m=0.08, track_m=0.4), sensor=(FRONT,))
    assert bounds(config) == approx((-0.08, 0.3, 0.22))
    assert bounds(robot_file.load(DEFAULT_ROBOT)) == approx((-0.1571, 0.1571, 0.18))


def test_a_steered_robot_s_box_ends_at_its_front_wheel() -> None:
    robot = RobotConfig(wheel_radius_m=0.1, wheelbase_m=0.8, drive="tricycle")
    assert bounds(Config(robot, sensor=(FRONT,))) == approx((-0.1, 0.9, 0.42))


def test_an_outline_that_is_given_is_taken() -> None:
    robot = RobotConfig(footprint=((0.4, 0.0), (-0.2, 0.2), (-0.2, -0.2)))
    assert footprint(Config(robot)).corners == robot.footprint


@pytest.mark.parametrize(
    ("corners", "why"),
    [
        (((0.0, 0.0), (1.0, 0.0)), "an outline has 3"),
        (((0.0, 0.0), (1.0, 0.0), (0.0,)), r"list of \[x_m, y_m\]"),
        (((0.0, 0.0), (1000.0, 0.0), (0.0, 1.0)), "in -100...100"),
        (((0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)), "crosses itself"),
    ],
)
def test_what_is_no_outline_is_refused_by_its_key(corners: tuple[tuple[float, ...], ...], why: str) -> None:
    with pytest.raises(ValueError, match=f"`footprint`.*{why}"):
        RobotConfig(footprint=corners)


@pytest.mark.parametrize(
    ("table", "key", "value"), [("obstacle", "horizon_m", 0.4), ("local", "size_m", 1.0)]
)
def test_a_robot_that_could_not_look_beyond_itself_is_refused(table: str, key: str, value: float) -> None:
    robot = replace(CONFIG.robot, footprint=((0.6, 0.0), (-0.2, 0.2), (-0.2, -0.2)))
    config = replace(CONFIG, robot=robot, **{table: replace(getattr(CONFIG, table), **{key: value})})
    with pytest.raises(ConfigError) as raised:
        assembly.parts(config)
    assert any(f"`{key}` must reach beyond" in what for _, what in raised.value.found)
