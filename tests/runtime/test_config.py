from dataclasses import fields, is_dataclass
from math import inf, pi
from typing import Literal

import pytest

from echogrid.runtime import config
from echogrid.runtime.config import Config, FiringConfig
from echogrid.runtime.hardware_config import SensorConfig

SENSOR = SensorConfig("front", 0.1, 0.2, 90.0, 15.0, 0.04, 4.0)


def test_a_sensor_is_the_map_s_ranger_in_radians() -> None:
    ranger = SENSOR.ranger()
    assert ranger.mount.yaw == pytest.approx(pi / 2)
    assert (ranger.mount.x, ranger.mount.y, ranger.nearest, ranger.farthest) == (0.1, 0.2, 0.04, 4.0)
    assert ranger.half_angle == pytest.approx(pi / 12)


def test_the_defaults_work() -> None:
    assert Config() == Config()


@pytest.mark.parametrize(
    ("kind", "changes"),
    [
        ("RobotConfig", {"wheel_radius_m": 0.0}),
        ("RobotConfig", {"track_m": inf}),
        ("RobotConfig", {"air_temperature_c": 300.0}),
        ("RobotConfig", {"wheel_ratio": 0.4}),
        ("RobotConfig", {"slip_factor": 11.0}),
        ("RobotConfig", {"wheel_error_mm": 0.0}),
        ("FiringConfig", {"gap_ms": 0.0}),
        ("FiringConfig", {"gap_ms": 50.0, "mode": "eeruf"}),
        ("FiringConfig", {"cycle_ms": 50.0}),
        ("FiringConfig", {"cycle_ms": 0.0, "mode": "eeruf"}),
        ("FiringConfig", {"separation_deg": 0.0}),
        ("FiringConfig", {"groups": (("a",),), "mode": "together"}),
        ("FiringConfig", {"jitter_ms": 101.0}),
        ("FiringConfig", {"listen_every": 1}),
        ("FiringConfig", {"general_call": True, "mode": "eeruf"}),
        ("FiringConfig", {"agreement_m": 0.0}),
        ("LoopConfig", {"rate_hz": 0.0}),
        ("LoopConfig", {"rate_hz": 1001.0}),
        ("MapConfig", {"resolution_m": 0.0}),
        ("MapConfig", {"width_m": 10.0}),
        ("MapConfig", {"width_m": 10.0, "height_m": -1.0}),
        ("MapConfig", {"tolerance_m": 0.0}),
        ("MapConfig", {"pose_gap_s": 0.0}),
        ("LocalConfig", {"size_m": 0.1}),
        ("LocalConfig", {"fade_s": 0.0}),
        ("ObstacleConfig", {"sectors": 3}),
        ("ObstacleConfig", {"horizon_m": 0.0}),
        ("ObstacleConfig", {"stop_distance_m": 0.0}),
        ("ObstacleConfig", {"stale_s": 0.0}),
        ("AvoidConfig", {"slow_mps": 0.0}),
        ("AvoidConfig", {"margin_m": -0.1}),
        ("AvoidConfig", {"deceleration_mps2": 0.0}),
        ("AvoidConfig", {"reaction_ms": 10_001.0}),
        ("AvoidConfig", {"skin_m": inf}),
        ("AvoidConfig", {"known_part": 0.0}),
    ],
)
def test_an_impossible_value_is_refused_by_its_key(kind: str, changes: dict[str, object]) -> None:
    with pytest.raises(ValueError, match=f"`{list(changes)[-1]}`|`{next(iter(changes))}`"):
        getattr(config, kind)(**changes)


@pytest.mark.parametrize(
    "changes",
    [
        {"half_angle_deg": 90.0},
        {"min_m": 4.0},
        {"min_m": -0.1},
        {"max_m": 101.0},
        {"x_m": 1e3},
        {"name": "a\nb"},
    ],
)
def test_an_impossible_sensor_is_refused_by_its_key(changes: dict[str, object]) -> None:
    values = {field.name: getattr(SENSOR, field.name) for field in fields(SENSOR)}
    with pytest.raises(ValueError, match=f"`{next(iter(changes))}`"):
        SensorConfig(**values | changes)


@pytest.mark.parametrize("gear", [0.0, 1e-5, 1e5])
def test_an_impossible_gear_is_refused(gear: float) -> None:
    with pytest.raises(ValueError, match="`gear`"):
        config.WheelConfig("left", "d", "b", gear)


@pytest.mark.parametrize(("mode", "compares"), [("groups", False), ("eeruf", True), ("together", True)])
def test_readings_are_compared_unless_groups_fire_in_turn_or_as_is_said(
    mode: Literal["groups", "eeruf", "together"], compares: bool
) -> None:
    assert FiringConfig(mode=mode).verifies is compares
    assert FiringConfig(mode=mode, verify=not compares).verifies is not compares


def test_every_table_is_frozen() -> None:
    tables = [each for each in vars(config).values() if isinstance(each, type) and is_dataclass(each)]
    own = [table for table in tables if table.__module__.startswith("echogrid.runtime.")]
    assert len(own) == 14
    assert all(table.__dataclass_params__.frozen for table in own)  # type: ignore[attr-defined]
