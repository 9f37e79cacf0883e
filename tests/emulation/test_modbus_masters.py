"""The emulated devices, served on real terminals, against the masters of two other Modbus libraries."""

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

import minimalmodbus
import pytest
from pymodbus.client import ModbusSerialClient

from echogrid.drivers.clock import MonotonicClock
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.robot import BusSpec, EmulatedRobot, RangerSpec, RobotSpec
from echogrid.emulation.scene import Echo
from echogrid.emulation.server import Server

LONG_S = 5.0
SPEC = RobotSpec(
    0.1,
    0.4,
    (BusSpec("urms", "serial"), BusSpec("dyp", "serial")),
    (
        RangerSpec("narrow", "urm14", "urms", 0.0, 0.0, 0.0),
        RangerSpec("wide", "urm15", "urms", 0.0, 0.0, 0.0),
        RangerSpec("rear", "dyp-rs485", "dyp", 0.0, 0.0, 0.0),
    ),
    (),
)


@pytest.fixture
def directory(tmp_path: Path) -> Iterator[Path]:
    """A directory in which the robot is served by a thread."""
    wall = Surroundings(lambda fire_ns: (Echo(1.2345, 40.0, "wall"),), 343.21)
    robot = EmulatedRobot(SPEC, lambda ranger: wall, lambda _: lambda _: 0.0)
    stop = threading.Event()
    with Server(robot, tmp_path / "robot", MonotonicClock()) as server:
        thread = threading.Thread(target=server.run, args=(stop,))
        thread.start()
        try:
            yield tmp_path / "robot"
        finally:
            stop.set()
            thread.join()


def instrument(directory: Path, bus: str, address: int, baud: int) -> minimalmodbus.Instrument:
    """A device, for the one library."""
    device = minimalmodbus.Instrument(str(directory / bus), address)
    device.serial.baudrate = baud
    device.serial.timeout = LONG_S
    return device


def comes_about(reached: Callable[[], bool]) -> bool:
    """Whether that gets so in time."""
    deadline_s = time.monotonic() + LONG_S
    while not (so := reached()) and time.monotonic() < deadline_s:
        pass
    return so


def test_minimalmodbus_pings_two_of_them_on_one_line(directory: Path) -> None:
    narrow, wide = (instrument(directory, "urms", address, 19_200) for address in (0x0C, 0x0F))
    with closing(narrow.serial):
        assert narrow.read_registers(0, 2) == [2, 0x10]
        assert wide.read_registers(0, 2) == [5, 0x10]
        for device, counts in ((narrow, 12_345), (wide, 1234)):
            assert device.read_register(5) == 0xFFFF
            device.write_register(8, 12, functioncode=6)
            assert comes_about(lambda device=device, counts=counts: device.read_register(5) == counts)
            assert device.read_register(8) == 4
            assert device.read_register(6, number_of_decimals=1, signed=True) == 20.0


def test_minimalmodbus_is_refused_by_name(directory: Path) -> None:
    device = instrument(directory, "urms", 0x0C, 19_200)
    device.serial.timeout = 1.0  # It awaits the bytes that a refusal has less than a reply.
    with (
        closing(device.serial),
        pytest.raises(minimalmodbus.IllegalRequestError, match="illegal data address"),
    ):
        device.read_register(0x20)


def test_minimalmodbus_reads_a_dyp(directory: Path) -> None:
    device = instrument(directory, "dyp", 1, 9600)
    with closing(device.serial):
        assert device.read_register(0x0101) == 1234
        assert device.read_register(0x0100) == 1234
        assert device.read_register(0x0102, number_of_decimals=1, signed=True) == 20.0


@pytest.fixture
def client(directory: Path) -> Iterator[ModbusSerialClient]:
    """The other library's master."""
    path = str(directory / "urms")
    with ModbusSerialClient(path, baudrate=19_200, timeout=LONG_S, retries=0) as master:
        yield master


def test_pymodbus_pings_a_urm14(client: ModbusSerialClient) -> None:
    assert client.read_holding_registers(0, count=2, device_id=0x0C).registers == [2, 0x10]
    assert client.write_register(8, 12, device_id=0x0C).registers == [12]
    assert comes_about(
        lambda: client.read_holding_registers(5, count=1, device_id=0x0C).registers == [12_345]
    )


def test_pymodbus_is_refused_with_the_right_codes(client: ModbusSerialClient) -> None:
    codes = [
        client.read_holding_registers(0x20, count=1, device_id=0x0C).exception_code,
        client.write_register(2, 0, device_id=0x0C).exception_code,
        client.write_registers(8, [4], device_id=0x0C).exception_code,
    ]
    assert codes == [2, 3, 1]
