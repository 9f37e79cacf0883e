"""The drivers through a real serial port, against the slave of another Modbus library."""

import os
import pty
import select
import threading
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager

import umodbus
from pytest import approx
from umodbus.exceptions import ServerDeviceBusyError
from umodbus.server.serial import get_server
from umodbus.server.serial.rtu import RTUServer

from echogrid.drivers.clock import MonotonicClock
from echogrid.drivers.conversation import Conversation
from echogrid.drivers.device import Device, State
from echogrid.drivers.dyp_rs485 import DypRs485
from echogrid.drivers.readings import Outcome, RangeReading, Reading
from echogrid.drivers.role import RangerRole
from echogrid.drivers.transports.serial import SerialPort
from echogrid.drivers.urm_modbus import Urm14
from echogrid.runtime.pump import Pump

umodbus.conf.SIGNED_VALUES = False

LONG_S = 10.0
ROLE = RangerRole("front", 0.05, 1.5, None, 343.0)


class FarEnd:
    """The other end of a pseudo-terminal, as much of a pyserial port as the library's server uses."""

    baudrate = 19_200
    timeout = 0.05
    inter_byte_timeout = None

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor

    def read(self, count: int) -> bytes:
        """What comes in one go, or nothing."""
        ready, _, _ = select.select([self._descriptor], [], [], self.timeout)
        return os.read(self._descriptor, count) if ready else b""

    def write(self, data: bytes) -> None:
        """Send."""
        os.write(self._descriptor, data)


class Slave:
    """Registers behind the library's routes."""

    def __init__(self, registers: dict[int, int], obey: Callable[[dict[int, int]], None]) -> None:
        self.registers = registers
        self.busy = False
        self._obey = obey

    def read(self, slave_id: int, function_code: int, address: int) -> int:
        """One register."""
        if self.busy:
            raise ServerDeviceBusyError
        return self.registers[address]

    def write(self, slave_id: int, function_code: int, address: int, value: int) -> None:
        """Set one register."""
        self.registers[address] = value
        self._obey(self.registers)


@contextmanager
def served(slave: Slave, address: int) -> Iterator[str]:
    """The path of a terminal at whose other end the slave is."""
    master, terminal = pty.openpty()
    server = get_server(RTUServer, FarEnd(master))
    addresses = list(slave.registers)
    server.route(slave_ids=[address], function_codes=[3], addresses=addresses)(slave.read)
    server.route(slave_ids=[address], function_codes=[6], addresses=addresses)(slave.write)
    thread = threading.Thread(target=server.serve_forever, args=(0.02,))
    thread.start()
    try:
        yield os.ttyname(terminal)
    finally:
        server.shutdown()
        thread.join()
        os.close(terminal)
        os.close(master)


class Bench:
    """A device, its real port, and time that passes by itself."""

    def __init__(self, device: Device, path: str) -> None:
        self.readings: list[Reading] = []
        self.port = SerialPort(path, **device.port_options)
        self._clock = MonotonicClock()
        line = Conversation("port", [device])
        self._pump = Pump(line, self.port, self._clock, self.readings.extend)

    def turn_until(self, reached: Callable[[], bool]) -> bool:
        """Carry on until that is so; whether it came about."""
        deadline_ns = self._clock.now_ns() + round(LONG_S * 1e9)
        while not reached() and self._clock.now_ns() < deadline_ns:
            self._pump.turn()
        return reached()

    def last(self) -> RangeReading:
        """The latest reading."""
        reading = self.readings[-1]
        assert isinstance(reading, RangeReading)
        return reading


def pings(registers: dict[int, int]) -> None:
    """Measure 1.2345 m when the trigger bit is set, and clear it."""
    if registers[8] & 8:
        registers[5] = 12_345
        registers[8] &= ~8


def test_a_urm14_is_set_up_and_pinged_through_another_library() -> None:
    slave = Slave({0: 2, 1: 0x10, 5: 0xFFFF, 6: 215, 7: 0, 8: 0}, pings)
    device = Urm14(ROLE, Urm14.Settings(clears_trigger=True, ping_ms=20.0))
    with served(slave, 0x0C) as path:
        bench = Bench(device, path)
        with closing(bench.port):
            assert bench.turn_until(lambda: len(bench.readings) >= 3)
            assert bench.last().outcome is Outcome.ECHO
            assert bench.last().distance == approx(1.2345)
            assert slave.registers[8] == 4
            assert device.health(bench.last().stamp_ns).state is State.WELL


def test_its_refusals_are_faults_and_pass() -> None:
    slave = Slave({0: 2, 1: 0x10, 5: 0xFFFF, 6: 215, 7: 0, 8: 4}, pings)
    device = Urm14(ROLE, Urm14.Settings(ping_ms=20.0))
    with served(slave, 0x0C) as path:
        slave.busy = True
        bench = Bench(device, path)
        with closing(bench.port):
            assert bench.turn_until(lambda: device.health(0).state is State.FAULTY)
            assert "device busy (Modbus exception 6)" in device.health(0).message
            slave.busy = False
            assert bench.turn_until(lambda: bool(bench.readings))
            assert bench.last().outcome is Outcome.ECHO


def test_a_register_that_is_not_there_is_refused_by_name() -> None:
    device = Urm14(ROLE, Urm14.Settings())
    with served(Slave({0: 2, 1: 0x10, 5: 0}, pings), 0x0C) as path:
        bench = Bench(device, path)
        with closing(bench.port):
            assert bench.turn_until(lambda: device.health(0).state is State.FAULTY)
            assert "illegal address (Modbus exception 2)" in device.health(0).message


def test_a_dyp_is_asked_through_another_library() -> None:
    slave = Slave({0x0100: 1111, 0x0101: 1953, 0x0102: 215}, lambda registers: None)
    device = DypRs485(RangerRole("rear", 0.03, 4.5, None, 343.0), DypRs485.Settings())
    with served(slave, 1) as path:
        bench = Bench(device, path)
        with closing(bench.port):
            assert bench.turn_until(lambda: len(bench.readings) >= 2)
            assert bench.last().distance == approx(1.953)
