from math import tau
from typing import Any

import pytest

from echogrid.drivers.bus import NEVER_NS, CanFrame, I2cMessage, I2cTransfer
from echogrid.drivers.clock import JumpingClock
from echogrid.drivers.errors import PortError
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.errors import RobotSpecError, UnknownNameError
from echogrid.emulation.robot import BusSpec, EmulatedRobot, RangerSpec, RobotSpec, WheelSpec
from echogrid.emulation.scene import Echo
from echogrid.emulation.wires.memory import MemoryPort

MS = 1_000_000
SECOND = 1000 * MS
BUSES = (BusSpec("port", "serial"), BusSpec("can", "can"), BusSpec("i2c", "i2c"))
RANGERS = (
    RangerSpec("left", "a02yyuw", "port", 0.1, 0.1, 1.57),
    RangerSpec("front", "srf08", "i2c", 0.2, 0.0, 0.0, {"address": 0x71}),
)
WHEELS = (WheelSpec("left_wheel", "odrive-0.5", "can", "left", {"node": 0}),)


def robot(
    buses: tuple[BusSpec, ...] = BUSES,
    rangers: tuple[RangerSpec, ...] = RANGERS,
    wheels: tuple[WheelSpec, ...] = WHEELS,
) -> EmulatedRobot:
    return EmulatedRobot(
        RobotSpec(0.1, 0.4, buses, rangers, wheels),
        lambda ranger: Surroundings(lambda fire_ns: (Echo(1.5, 20.0, "wall"),), 343.21),
        lambda side: lambda now_ns: tau * now_ns / SECOND,
    )


class Bench:
    """The emulated robot's ports on a clock that jumps."""

    def __init__(self) -> None:
        self.clock = JumpingClock()
        self.robot = robot()
        self.ports = self.robot.ports(self.clock)

    def open(self, name: str) -> MemoryPort[Any, Any]:
        port = self.ports[name]
        port.open()
        return port

    def next_read(self, port: MemoryPort[Any, Any]) -> list[Any]:
        """What comes next, after jumping from event to event."""
        while not (items := list(port.read(0.0))):
            self.clock.sleep_until_ns(port.ready_ns())
        return items


def test_serial_bytes_come_one_by_one_in_the_time_of_ten_bits() -> None:
    bench = Bench()
    port = bench.open("port")
    heard = [(bench.next_read(port)[0], bench.clock.now_ns()) for _ in range(4)]
    assert b"".join(data for data, _ in heard) == bytes.fromhex("FF05DCE0")
    assert heard[3][1] - heard[0][1] == pytest.approx(3 * 10 * SECOND / 9600, abs=1)


def test_can_frames_are_ready_at_their_end() -> None:
    bench = Bench()
    port = bench.open("can")
    (frame,) = bench.next_read(port)
    assert (frame.identifier, bench.clock.now_ns(), frame.stamp_ns) == (0x001, 222_000, 222_000)


def test_i2c_results_are_ready_after_nine_bits_a_byte() -> None:
    bench = Bench()
    port = bench.open("i2c")
    transfer = I2cTransfer((I2cMessage(0x71, b"\0"), I2cMessage(0x71, read=1)))
    port.write((transfer,))
    assert list(port.read(0.0)) == []
    (result,) = bench.next_read(port)
    assert (result.transfer, result.data, result.errno) == (transfer, b"\x0a", 0)
    assert result.end_ns == bench.clock.now_ns() == 4 * 90_000


def test_transfers_go_one_after_the_other() -> None:
    bench = Bench()
    port = bench.open("i2c")
    port.write([I2cTransfer((I2cMessage(0x71, b"\0"),))] * 2)
    first, second = bench.next_read(port)[0], bench.next_read(port)[0]
    assert second.start_ns == first.end_ns


def test_nothing_is_due_at_a_closed_port() -> None:
    assert Bench().ports["can"].ready_ns() == NEVER_NS


def test_what_came_before_opening_is_not_seen() -> None:
    bench = Bench()
    bench.clock.sleep_until_ns(SECOND)
    assert list(bench.open("can").read(0.0)) == []


@pytest.mark.parametrize("name", ["port", "can", "i2c"])
def test_an_unplugged_bus_raises_until_it_is_plugged_in_and_opened_again(name: str) -> None:
    bench = Bench()
    port = bench.open(name)
    bench.robot.fault(name, "unplug", 0, SECOND)
    assert port.ready_ns() == 0
    with pytest.raises(PortError, match=f"{name}: the port is lost"):
        port.read(0.0)
    with pytest.raises(PortError, match=f"{name}: the port is lost"):
        port.write(())
    port.close()
    with pytest.raises(PortError, match=f"{name}: no such port"):
        port.open()
    bench.clock.sleep_until_ns(SECOND)
    port.open()
    assert list(port.read(0.0)) == []


def test_a_port_that_blinked_between_two_reads_is_lost_all_the_same() -> None:
    bench = Bench()
    port = bench.open("can")
    bench.robot.fault("can", "unplug", 0)
    bench.robot.clear("can", 0)
    with pytest.raises(PortError, match="lost"):
        port.read(0.0)


def test_an_unplugged_serial_sensor_takes_its_port_along() -> None:
    bench = Bench()
    port = bench.open("port")
    bench.robot.fault("left", "unplug", 0)
    with pytest.raises(PortError):
        port.read(0.0)


def test_a_port_that_was_not_opened_refuses() -> None:
    with pytest.raises(PortError, match="closed"):
        Bench().ports["can"].write((CanFrame(0, b""),))


def test_two_robots_of_one_seed_send_the_same() -> None:
    first, second = Bench(), Bench()
    for bench in (first, second):
        bench.robot.fault("left_wheel", "garbage", 0)
        bench.open("can")
        bench.clock.sleep_until_ns(SECOND)
    assert list(first.ports["can"].read(0.0)) == list(second.ports["can"].read(0.0))


def test_active_faults_are_listed_until_their_time_is_over() -> None:
    emulated = Bench().robot
    emulated.fault("front", "delayed", 0, SECOND)
    emulated.fault("can", "unplug", 0)
    assert [(fault.name, fault.verb) for fault in emulated.active_faults(0)] == [
        ("front", "delayed"),
        ("can", "unplug"),
    ]
    assert [fault.name for fault in emulated.active_faults(SECOND)] == ["can"]


def test_an_unknown_name_is_told_with_the_nearest_one() -> None:
    with pytest.raises(UnknownNameError, match=r"no device or bus 'frnt'.*did you mean 'front'"):
        robot().fault("frnt", "off", 0)
    with pytest.raises(UnknownNameError):
        robot().device("can")


@pytest.mark.parametrize(
    ("buses", "rangers", "message"),
    [
        (BUSES[2:], (RangerSpec("a", "srf8", "i2c", 0, 0, 0),), r"a: no model 'srf8'.*'srf08'"),
        (BUSES[2:], (RangerSpec("a", "lidar", "i2c", 0, 0, 0),), "there are: a02yyuw, "),
        (BUSES[2:], (RangerSpec("a", "srf08", "ic2", 0, 0, 0),), "a: no bus 'ic2'.*'i2c'"),
        (BUSES[2:], (RangerSpec("a", "a02yyuw", "i2c", 0, 0, 0),), "needs a serial bus"),
        (BUSES[2:], (RangerSpec("a", "srf08", "i2c", 0, 0, 0, {"adress": 1}),), "'adress'.*'address'"),
        (BUSES[2:], (RangerSpec("a", "srf08", "i2c", 0, 0, 0, {"address": 1.5}),), "whole number"),
        (BUSES[2:], (RangerSpec("a", "srf08", "i2c", 0, 0, 0, {"address": 0xE0}),), "0xe0"),
        (BUSES[2:], (RANGERS[1], RangerSpec("b", "srf08", "i2c", 0, 0, 0, {"address": 0x71})), "share"),
        (BUSES[2:], (RANGERS[1], RANGERS[1]), "two parts of this name"),
        (BUSES[:1], (), "a serial line without a device"),
        ((BusSpec("port", "serial", 115200),), RANGERS[:1], "9600 baud, not 115200"),
        ((BusSpec("a/b", "can"),), (), "not a name"),
        ((BusSpec("spi", "spi"),), (), "no kind of bus 'spi'"),
    ],
)
def test_a_robot_that_cannot_be_is_refused(
    buses: tuple[BusSpec, ...], rangers: tuple[RangerSpec, ...], message: str
) -> None:
    with pytest.raises(RobotSpecError, match=message):
        robot(buses, rangers, ())


def test_wheels_are_left_or_right_and_have_a_node_that_fits() -> None:
    with pytest.raises(RobotSpecError, match="left, right"):
        robot(BUSES[1:2], (), (WheelSpec("w", "odrive-0.5", "can", "middle"),))
    with pytest.raises(RobotSpecError, match="w: node 64"):
        robot(BUSES[1:2], (), (WheelSpec("w", "odrive-0.5", "can", "left", {"node": 64}),))
