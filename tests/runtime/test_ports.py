from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from echogrid.drivers.bus import Port
from echogrid.drivers.errors import PortError
from echogrid.runtime import lines, robot_file
from echogrid.runtime.config import Config
from echogrid.runtime.emulated import DEFAULT_ROBOT
from echogrid.runtime.errors import ConfigError
from echogrid.runtime.hardware_config import BusConfig
from echogrid.runtime.ports import real_ports


def with_bus(name: str, **changes: Any) -> Config:
    config = robot_file.load(DEFAULT_ROBOT)
    return replace(config, bus=tuple(replace(b, **changes) if b.name == name else b for b in config.bus))


def ports(config: Config, folder: Path) -> dict[str, Port[Any, Any]]:
    return real_ports(config, lines.lines(config), folder)


@pytest.mark.parametrize(
    ("bus", "changes", "address"),
    [
        ("ring_bus", {}, "/robot/ring_bus.sock"),
        ("ring_bus", {"port": "/dev/i2c-77"}, "/dev/i2c-77"),
        ("ring_bus", {"port": "unix:/run/bus.sock"}, "/run/bus.sock"),
        ("wheel_bus", {}, "/robot/wheel_bus"),
        ("wheel_bus", {"port": "/dev/none"}, "/dev/none"),
        ("wheel_bus", {"interface": "socketcan", "port": "can77"}, "can77"),
        ("front_left_line", {}, "/robot/front_left_line"),
        ("front_left_line", {"port": "/dev/ttyNONE"}, "/dev/ttyNONE"),
    ],
)
def test_a_port_that_is_missing_is_named_by_its_address_with_the_mend(
    bus: str, changes: dict[str, str], address: str
) -> None:
    port = ports(with_bus(bus, **changes), Path("/robot"))[bus]
    with pytest.raises(PortError, match=rf"^{address}: cannot open this .*: ."):
        port.open()


def test_every_line_has_its_port() -> None:
    config = robot_file.load(DEFAULT_ROBOT)
    assert set(ports(config, Path())) == {bus.name for bus in config.bus}


def test_a_bus_without_devices_needs_no_port() -> None:
    config = robot_file.load(DEFAULT_ROBOT)
    config = replace(config, bus=(*config.bus, BusConfig("spare", "serial", "/dev/none")))
    assert "spare" not in ports(config, Path())


def test_all_impossible_bit_rates_are_told_at_once() -> None:
    config = robot_file.load(DEFAULT_ROBOT)
    wrong = replace(config, bus=tuple(replace(bus, bit_rate=1) for bus in config.bus))
    with pytest.raises(ConfigError) as caught:
        real_ports(wrong, lines.lines(config), Path())
    assert [place for place, _ in caught.value.found] == [("bus", index) for index in range(1, 6)]
