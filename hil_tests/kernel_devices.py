"""Emulated buses on wires of the kernel, run by a thread, and what their devices sense."""

import os
import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from queue import SimpleQueue
from random import Random
from typing import Any, Self

from echogrid.drivers.clock import MonotonicClock
from echogrid.emulation.buses.bus import Bus
from echogrid.emulation.buses.can_bus import CanBus
from echogrid.emulation.buses.i2c_bus import I2cBus
from echogrid.emulation.buses.serial_line import SerialLine
from echogrid.emulation.devices.a02yyuw import A02yyuwSensor
from echogrid.emulation.devices.can_node import CanNode
from echogrid.emulation.devices.device import EmulatedDevice
from echogrid.emulation.devices.i2c_chip import I2cChip
from echogrid.emulation.devices.odrive import ODriveAxis, ODriveOptions
from echogrid.emulation.devices.srf08 import Srf08Chip, Srf08Options
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.scene import Echo
from echogrid.emulation.wires.loop import Loop
from echogrid.emulation.wires.usb_i2c import UsbI2cWire
from echogrid.emulation.wires.usb_serial import UsbSerialWire
from echogrid.emulation.wires.vcan import VcanWire
from echogrid.emulation.wires.wire import Wire

SPEED_OF_SOUND = 343.2
BUS_RATE = 100_000
BIT_RATE = 500_000
ESTIMATES_NS = 10_000_000
LONGEST_WAIT_S = 0.1


@dataclass(slots=True)
class Wall:
    """All that a ranger hears: one wall, which can be moved."""

    distance: float
    """m."""

    def __call__(self, fire_ns: int) -> tuple[Echo, ...]:
        return (Echo(self.distance, 60.0, "wall"),)

    def surroundings(self) -> Surroundings:
        """With the bench's air."""
        return Surroundings(self, SPEED_OF_SOUND)


class KernelDevices:
    """Buses whose devices this machine's kernel sees. Enter to start the thread that runs them.

    Buses are made first and plugged in later, in any order; the thread alone touches them after that.
    """

    def __init__(self) -> None:
        self.clock = MonotonicClock()
        self.loop = Loop()
        self.wires: dict[str, Wire[Any, Any]] = {}
        self._buses: dict[str, Bus[Any, Any]] = {}
        self._orders: SimpleQueue[Callable[[], None]] = SimpleQueue()
        self._bell = os.eventfd(0, os.EFD_NONBLOCK)
        self._stop = False
        self._thread = threading.Thread(target=self._run, name="emulated devices")

    def __enter__(self) -> Self:
        self.loop.watch(self._bell, self._obey)
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop = True
        os.eventfd_write(self._bell, 1)
        self._thread.join()
        for wire in self.wires.values():
            wire.close()
        self.loop.close()
        os.close(self._bell)

    def i2c(self, serial: str, walls: Mapping[int, Wall]) -> None:
        """A USB adapter with an SRF08 for each address, plugged in."""
        chips = [
            Srf08Chip(f"srf08 {address:#x}", wall.surroundings(), Random(address), Srf08Options(address))
            for address, wall in walls.items()
        ]
        self.i2c_chips(serial, chips)

    def i2c_chips(self, serial: str, chips: Sequence[I2cChip]) -> None:
        """A USB adapter with these chips, plugged in."""
        bus = I2cBus(serial, BUS_RATE, chips)
        self._plug(serial, bus, UsbI2cWire(bus, serial, self.clock, self.loop))

    def serial(self, serial: str, wall: Wall) -> UsbSerialWire:
        """A USB adapter with an A02YYUW, plugged in."""
        line = SerialLine(serial, A02yyuwSensor(serial, wall.surroundings(), Random(serial)))
        wire = UsbSerialWire(line, serial, self.clock, self.loop, Random(serial))
        self._plug(serial, line, wire)
        return wire

    def can(self, interface: str, speeds: Mapping[int, float], estimates_ns: int = ESTIMATES_NS) -> None:
        """An ODrive axis for each node, whose wheel turns at that speed (rad/s) and is told of so often."""
        nodes = [
            ODriveAxis(
                f"axis {node}",
                self.turning(speed),
                Random(node),
                ODriveOptions(node, estimates_ns=estimates_ns),
            )
            for node, speed in speeds.items()
        ]
        self.can_nodes(interface, nodes)

    def can_nodes(self, interface: str, nodes: Sequence[CanNode]) -> None:
        """These nodes on a CAN interface, switched on."""
        bus = CanBus(interface, BIT_RATE, nodes)
        self._plug(interface, bus, VcanWire(bus, interface, self.clock, self.loop))

    def turning(self, speed: float) -> Callable[[int], float]:
        """The angle of a wheel that turns at that speed (rad/s), from 0 now."""
        started_ns = self.clock.now_ns()
        return lambda now_ns: speed * (now_ns - started_ns) * 1e-9

    def fail(self, device: EmulatedDevice, verb: str, for_ns: int) -> None:
        """Have a device fail for so long."""
        self._do(lambda: device.fault(verb, self.clock.now_ns(), for_ns))

    def unplug(self, name: str) -> None:
        """Pull its cable."""
        bus = self._buses[name]

        def pull() -> None:
            bus.advance(self.clock.now_ns())
            bus.fault("unplug", self.clock.now_ns())

        self._do(pull)

    def plug_in(self, name: str) -> None:
        """Put its cable back."""
        self._do(lambda: self._buses[name].clear(self.clock.now_ns()))

    def _plug(self, name: str, bus: Bus[Any, Any], wire: Wire[Any, Any]) -> None:
        def begin() -> None:
            bus.switch_on(self.clock.now_ns())
            self._buses[name], self.wires[name] = bus, wire

        self._do(begin)

    def _do(self, order: Callable[[], None]) -> None:
        """Have the thread do it, and see to its wires; return when that is done. Raises what it raises."""
        done = threading.Event()
        raised: list[Exception] = []

        def obey() -> None:
            try:
                order()
                self._pump()
            except Exception as error:  # noqa: BLE001 - it is raised where it was asked for
                raised.append(error)
            done.set()

        self._orders.put(obey)
        os.eventfd_write(self._bell, 1)
        done.wait()
        if raised:
            raise raised[0]

    def _obey(self) -> None:
        os.eventfd_read(self._bell)
        while not self._orders.empty():
            self._orders.get()()

    def _run(self) -> None:
        while not self._stop:
            self._pump()
            due_ns = min((bus.next_event_ns() for bus in self._buses.values()), default=0)
            wait_s = (due_ns - self.clock.now_ns()) * 1e-9 if self._buses else LONGEST_WAIT_S
            self.loop.wait(min(wait_s, LONGEST_WAIT_S))

    def _pump(self) -> None:
        for wire in self.wires.values():
            wire.pump()
