from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from echogrid.runtime import assembly, lines, robot_file
from echogrid.runtime.config import Config, FiringConfig
from echogrid.runtime.emulated import DEFAULT_ROBOT
from echogrid.runtime.errors import ConfigError, UsageError
from echogrid.runtime.hardware_config import BusConfig, RobotConfig


@pytest.fixture(scope="module")
def config() -> Config:
    return robot_file.load(DEFAULT_ROBOT)


def test_every_device_hangs_on_its_bus_in_the_order_of_the_file(config: Config) -> None:
    on_buses = {line.name: [device.name for device in line.devices] for line in lines.lines(config)}
    assert on_buses["ring_bus"] == [f"ring_{angle}" for angle in range(0, 360, 45)]
    assert on_buses["wheel_bus"] == ["left", "right"]
    assert on_buses["rear_left_line"] == ["rear_left"]


def test_a_sensor_without_a_driver_can_be_mapped_but_not_run(config: Config) -> None:
    bare = replace(config, sensor=(replace(config.sensor[0], driver=None),))
    assert assembly.geometry(bare).rows == 400
    with pytest.raises(ConfigError, match=r"sensor\[0\]: ring_0: `driver` and `bus` are needed to run"):
        lines.lines(bare)


def test_a_run_needs_both_wheels(config: Config) -> None:
    with pytest.raises(
        ConfigError, match="a run needs a \\[\\[wheel\\]\\] named `left` and one named `right`"
    ):
        lines.lines(replace(config, wheel=config.wheel[:1]))


@given(st.floats(0.9, 1.1), st.floats(1.0, 2.0), st.floats(0.1, 50.0))
def test_the_drive_has_the_configured_measures(ratio: float, slip: float, error_mm: float) -> None:
    robot = RobotConfig("r", 0.06, 0.3, ratio, slip, error_mm)
    drive = assembly.differential(Config(robot=robot), "this")
    assert drive.right_radius / drive.left_radius == pytest.approx(ratio)
    assert (drive.left_radius + drive.right_radius) / 2.0 == pytest.approx(0.06)
    assert drive.track == pytest.approx(0.3 * slip)
    assert drive.spread == pytest.approx((error_mm / 1000.0) ** 2)


@pytest.mark.parametrize(("width", "resolution"), [(1e9, 0.1), (1e300, 0.005), (float("nan"), 1.0)])
def test_a_map_with_too_many_cells_is_refused_in_words(width: float, resolution: float) -> None:
    with pytest.raises(UsageError, match="more than 4e\\+07"):
        assembly.bounded(0.0, 0.0, width, width, resolution)


def test_the_largest_map_is_not_refused() -> None:
    assert assembly.bounded(0.0, 0.0, 632.0, 632.0, 0.1).rows == 6320


def test_devices_that_would_answer_for_each_other_are_refused_with_both_names() -> None:
    config = robot_file.load(DEFAULT_ROBOT)
    sensors = list(config.sensor)
    sensors[1] = replace(sensors[1], settings=sensors[0].settings)
    sensors[-1] = replace(sensors[-1], bus=sensors[-2].bus)
    wheels = tuple(replace(wheel, settings={}) for wheel in config.wheel)
    with pytest.raises(ConfigError) as told:
        lines.lines(replace(config, sensor=tuple(sensors), wheel=wheels))
    text = str(told.value)
    assert f"{sensors[1].name} and {sensors[0].name} share address 0x70" in text
    assert f"{sensors[-1].name} and {sensors[-2].name} share the serial line" in text
    assert "right and left share node 0" in text


def line_with(*sensors: tuple[str, dict[str, object]], bit_rate: int | None = None) -> Config:
    """The emulated robot with more rangers, all on one serial line."""
    config = robot_file.load(DEFAULT_ROBOT)
    more = tuple(
        replace(config.sensor[0], name=f"more_{n}", driver=driver, bus="line", settings=settings)
        for n, (driver, settings) in enumerate(sensors)
    )
    bus = BusConfig("line", "serial", "line", bit_rate=bit_rate)
    return replace(config, bus=(*config.bus, bus), sensor=(*config.sensor, *more), firing=FiringConfig())


def test_rangers_that_are_spoken_to_share_a_line() -> None:
    shared = line_with(("urm12", {"address": 1}), ("urm15", {"address": 2}))
    assert [len(line.devices) for line in lines.lines(shared) if line.name == "line"] == [2]


@pytest.mark.parametrize(
    ("sensors", "bit_rate", "told"),
    [
        ((("urm12", {"address": 1}), ("a02yyuw", {})), None, "can't share bus 'line': one talks unasked"),
        ((("urm12", {}), ("dyp-rs485", {})), None, "differ on bus 'line'"),
        ((("urm12", {"address": 1}), ("urm15", {"address": 1})), None, "share address 1"),
        ((("urm12", {}),), 9600, "say its `baud` here"),
    ],
)
def test_rangers_that_can_t_be_on_one_line_are_refused(
    sensors: tuple[tuple[str, dict[str, object]], ...], bit_rate: int | None, told: str
) -> None:
    with pytest.raises(ConfigError, match=told):
        lines.lines(line_with(*sensors, bit_rate=bit_rate))


def test_controllers_of_other_bit_rates_share_a_bus_that_says_one() -> None:
    config = robot_file.load(DEFAULT_ROBOT)
    left, right = config.wheel
    mixed = replace(right, driver="vesc", settings={"node": 1})
    config = replace(config, wheel=(left, mixed))
    assert [len(line.devices) for line in lines.lines(config) if line.name == "wheel_bus"] == [2]
    buses = tuple(replace(bus, bit_rate=None) for bus in config.bus)
    with pytest.raises(ConfigError, match=r"differ on bus 'wheel_bus': .*say that `bit_rate` at the bus"):
        lines.lines(replace(config, bus=buses))


def test_a_plan_is_refused_wherever_a_run_is() -> None:
    with pytest.raises(ConfigError, match="share address"):
        lines.plan_of(line_with(("urm12", {"address": 1}), ("urm15", {"address": 1})))
