"""The udev rules: a bus has one role, whatever was plugged in first; and what hangs on it comes back."""

import grp
import stat
import subprocess
from collections.abc import Iterator
from contextlib import closing, contextmanager
from itertools import permutations
from pathlib import Path

from pytest import approx, fixture, mark

from echogrid.drivers.device import Level
from echogrid.drivers.readings import RangeReading
from echogrid.drivers.transports.serial import SerialPort
from hil_tests.kernel import (
    ROLES,
    command,
    install_rules,
    node_behind,
    remove_rules,
    serial_of,
    wait_for,
)
from hil_tests.kernel_devices import KernelDevices, Wall
from hil_tests.pumping import Readout, a02yyuw

LEFT, RIGHT, RING = "front_left", "front_right", "ring"
MAP = "59-echogrid-roles.rules"
DISTANCE = 1.234

pytestmark = mark.usefixtures("guest")


@fixture(scope="module")
def rangers(devices: KernelDevices) -> KernelDevices:
    """Two serial rangers and an I2C adapter, all unplugged."""
    devices.serial(LEFT, Wall(DISTANCE))
    devices.serial(RIGHT, Wall(2.0))
    devices.i2c(RING, {0x70: Wall(1.0)})
    for role in (LEFT, RIGHT, RING):
        unplug(devices, role)
    return devices


def plug_in(devices: KernelDevices, role: str) -> Path:
    """The node that the role then stands for."""
    devices.plug_in(role)
    return wait_for(f"role {role}", lambda: node_behind(role))


def unplug(devices: KernelDevices, role: str) -> None:
    """And wait until the role is gone."""
    if role not in (LEFT, RIGHT, RING) or not (ROLES / role).is_symlink():
        wait_for(f"role {role}", lambda: node_behind(role))
    devices.unplug(role)
    wait_for(f"end of role {role}", lambda: not (ROLES / role).is_symlink())


@contextmanager
def plugged_in(devices: KernelDevices, *roles: str) -> Iterator[list[Path]]:
    """Their nodes, in the order in which they were plugged in."""
    nodes = [plug_in(devices, role) for role in roles]
    yield nodes
    for role in roles:
        unplug(devices, role)


@contextmanager
def role_map(*lines: str) -> Iterator[None]:
    """A machine's own roles."""
    install_rules(MAP, "\n".join(lines) + "\n")
    yield
    remove_rules(MAP)


@mark.parametrize("order", [*permutations((LEFT, RIGHT, RING))], ids=" ".join)
def test_a_role_is_the_same_in_any_order(rangers: KernelDevices, order: tuple[str, ...]) -> None:
    with plugged_in(rangers, *order) as nodes:
        kinds = {role: "i2c-dev" if role == RING else "tty" for role in order}
        found = [
            serial_of(Path("/sys/class", kinds[role], node.name))
            for role, node in zip(order, nodes, strict=True)
        ]
    assert found == list(order)


@mark.parametrize(("role", "group"), [(LEFT, "dialout"), (RING, "i2c")])
def test_a_role_belongs_to_its_group_and_is_a_unit(rangers: KernelDevices, role: str, group: str) -> None:
    with plugged_in(rangers, role) as (node,):
        status = node.stat()
        unit = command("systemd-escape", "--path", "--suffix=device", str(ROLES / role)).strip()
        wait_for(f"unit {unit}", lambda: is_active(unit))
    assert grp.getgrgid(status.st_gid).gr_name == group
    assert stat.S_IMODE(status.st_mode) == 0o660
    wait_for(f"end of unit {unit}", lambda: not is_active(unit))


def is_active(unit: str) -> bool:
    return subprocess.run(["systemctl", "is-active", "--quiet", unit], check=False).returncode == 0


def test_a_machines_own_map_of_serial_numbers_goes_first(rangers: KernelDevices) -> None:
    line = f'SUBSYSTEM=="tty", ATTRS{{serial}}=="{LEFT}", ENV{{ECHOGRID_ROLE}}="rear"'
    with role_map(line):
        rangers.plug_in(LEFT)
        node = wait_for("role rear", lambda: node_behind("rear"))
        assert serial_of(Path("/sys/class/tty", node.name)) == LEFT
        assert not (ROLES / LEFT).exists()
        rangers.unplug(LEFT)
        wait_for("end of role rear", lambda: not (ROLES / "rear").is_symlink())


def test_an_i2c_adapter_has_its_role_by_its_name(rangers: KernelDevices) -> None:
    with role_map('SUBSYSTEM=="i2c-dev", ATTR{name}=="i2c-tiny-usb at *", ENV{ECHOGRID_ROLE}="sonars"'):
        rangers.plug_in(RING)
        node = wait_for("role sonars", lambda: node_behind("sonars"))
        assert serial_of(Path("/sys/class/i2c-dev", node.name)) == RING
        rangers.unplug(RING)
        wait_for("end of role sonars", lambda: not (ROLES / "sonars").is_symlink())


def test_a_can_interface_has_its_role_as_its_name(guest: None) -> None:
    with role_map('SUBSYSTEM=="net", KERNEL=="vcan7", ENV{ECHOGRID_ROLE}="wheels"'):
        command("ip", "link", "add", "vcan7", "type", "vcan")
        wait_for("interface wheels", lambda: Path("/sys/class/net/wheels").exists())
    command("ip", "link", "delete", "wheels")


def test_readings_come_back_under_another_number(rangers: KernelDevices) -> None:
    first = plug_in(rangers, LEFT)
    device = a02yyuw()
    with closing(Readout(SerialPort(str(ROLES / LEFT)), device)) as readout:
        assert distances(readout.ranges(3)) == [approx(DISTANCE, abs=0.001)] * 3
        rangers.unplug(LEFT)
        readout.until(lambda _: readout.pump.losses == 1, "the loss")
        other = plug_in(rangers, RIGHT)
        second = plug_in(rangers, LEFT)
        assert (other, second) == (first, Path("/dev/ttyUSB1"))
        assert distances(readout.ranges(3)) == [approx(DISTANCE, abs=0.001)] * 3
        assert device.health(rangers.clock.now_ns()).level is Level.OK
    for role in (LEFT, RIGHT):
        unplug(rangers, role)


def distances(readings: list[RangeReading]) -> list[float]:
    return [reading.distance for reading in readings]


def test_the_device_sees_the_speed_and_a_wrong_one_gives_garbage(rangers: KernelDevices) -> None:
    with plugged_in(rangers, LEFT), closing(SerialPort(str(ROLES / LEFT), baud=19_200)) as port:
        port.open()
        wire = rangers.wires[LEFT]
        wait_for("the speed", lambda: getattr(wire, "baud", None) == approx(19_200, rel=0.01))
        heard = b"".join(b"".join(port.read(1.0)) for _ in range(5))
    assert heard
    assert DISTANCE_BYTES not in heard


DISTANCE_BYTES = b"\xff\x04\xd2"
