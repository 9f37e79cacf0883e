from dataclasses import replace

import pytest

from echogrid.runtime import robot_file
from echogrid.runtime.config import Config
from echogrid.runtime.emulated import DEFAULT_ROBOT, emulated_robot, robot_spec
from echogrid.runtime.errors import ConfigError


@pytest.fixture(scope="module")
def config() -> Config:
    return robot_file.load(DEFAULT_ROBOT)


def test_the_emulated_robot_has_the_buses_and_devices_of_the_configuration(config: Config) -> None:
    spec = robot_spec(config)
    assert [bus.name for bus in spec.buses] == [bus.name for bus in config.bus]
    assert [ranger.name for ranger in spec.rangers] == [sensor.name for sensor in config.sensor]
    assert [wheel.options["node"] for wheel in spec.wheels] == [0, 1]
    assert [ranger.options.get("address") for ranger in spec.rangers[:8]] == list(range(0x70, 0x78))


def test_its_devices_and_buses_can_be_made_to_fail_by_the_names_of_the_configuration(config: Config) -> None:
    names = {each.name for each in (*config.bus, *config.sensor, *config.wheel)}
    assert set(emulated_robot(config, 0, 1).verbs()) == names


def test_a_robot_that_cannot_run_cannot_be_emulated(config: Config) -> None:
    wrong = replace(config.sensor[0], settings={"address": [1]})
    with pytest.raises(ConfigError, match="expected a whole number, not \\[1\\]"):
        emulated_robot(replace(config, sensor=(wrong,)), 0, 1)


def test_all_drivers_without_an_emulator_are_told_with_their_places(config: Config) -> None:
    strange = tuple(replace(sensor, driver="new") for sensor in config.sensor[:2])
    with pytest.raises(ConfigError) as caught:
        robot_spec(replace(config, sensor=strange))
    assert [place for place, _ in caught.value.found] == [("sensor", 0, "driver"), ("sensor", 1, "driver")]
    assert "'new' has no emulator (there are: a02yyuw, " in str(caught.value)
