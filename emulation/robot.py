"""An emulated robot: its devices on their buses, built from a description."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from random import Random
from typing import Any, TypeVar

from echogrid.drivers.bus import NEVER_NS
from echogrid.drivers.clock import Clock
from echogrid.emulation.buses.can_bus import CanBus
from echogrid.emulation.buses.i2c_bus import I2cBus
from echogrid.emulation.buses.iio_bus import IioBus
from echogrid.emulation.buses.serial_line import SerialLine
from echogrid.emulation.devices.can_node import CanNode
from echogrid.emulation.devices.device import EmulatedDevice
from echogrid.emulation.devices.i2c_chip import I2cChip
from echogrid.emulation.devices.iio_device import IioDevice
from echogrid.emulation.devices.serial_device import SerialDevice
from echogrid.emulation.devices.shaft import Shaft
from echogrid.emulation.devices.slip import SlippingShaft
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.errors import RobotSpecError, UnknownNameError
from echogrid.emulation.faults import ActiveFault, Fallible, Verb
from echogrid.emulation.models import GYROS, RANGERS, WHEELS, Model, did_you_mean
from echogrid.emulation.wires.memory import MemoryPort

_CAN_RATE = 500_000
_I2C_RATE = 100_000
_NAME = re.compile(r"(?!control$)\w[\w-]*", re.ASCII)
"""Fit for a file name, and not that of the control socket."""

_SIDES = ("left", "right", "drive", "steering")

Sensed = TypeVar("Sensed")
Part = TypeVar("Part")


@dataclass(frozen=True, slots=True)
class BusSpec:
    """A bus. Its name and those of the devices are one set: faults are given by name."""

    name: str
    kind: str
    """"serial", "can", "i2c" or "iio"."""
    rate: int | None = None
    """bit/s; None: 500 000 for CAN, 100 000 for I2C, its device's own for a serial line."""


@dataclass(frozen=True, slots=True)
class RangerSpec:
    """A ranger, where it looks from (m, rad; x forward, y left, of the robot), and its model's options."""

    name: str
    model: str
    bus: str
    x: float
    y: float
    yaw: float
    options: Mapping[str, int | float | str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class WheelSpec:
    """A wheel with an encoder."""

    name: str
    model: str
    bus: str
    side: str
    """"left" or "right"; of a steered robot "drive" or "steering"."""
    options: Mapping[str, int | float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class GyroSpec:
    """A yaw gyro."""

    name: str
    model: str
    bus: str
    options: Mapping[str, int | float | str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class RobotSpec:
    """A robot on two wheels, or a steered one."""

    wheel_radius: float
    """m."""
    track: float
    """m, between the wheels; of a steered robot from axle to axle."""
    buses: tuple[BusSpec, ...]
    rangers: tuple[RangerSpec, ...]
    wheels: tuple[WheelSpec, ...]
    gyros: tuple[GyroSpec, ...] = ()


class EmulatedRobot:
    """The buses and devices of a robot.

    `surroundings_of` gives what a ranger has around it, `shaft_of` the true angle (rad) of the wheel on a
    side as a function of time (ns), or its Shaft if its motor shall turn it, `yaw_rate` how fast the robot
    turns (rad/s) then. Each wheel has a fault `slip` besides those of its controller. Its devices have no
    power before `switch_on`, which `ports` and the server call.
    """

    def __init__(
        self,
        spec: RobotSpec,
        surroundings_of: Callable[[RangerSpec], Surroundings],
        shaft_of: Callable[[str], Callable[[int], float]],
        *,
        yaw_rate: Callable[[int], float] = lambda _: 0.0,
        seed: int = 0,
    ) -> None:
        """Raises RobotSpecError, which is a ValueError, if such a robot cannot be."""
        self.spec = spec
        self._seed = seed
        _require_names(spec)
        rangers = {
            ranger.name: self._build(ranger, RANGERS, surroundings_of(ranger)) for ranger in spec.rangers
        }
        wheels = {wheel.name: self._wheel(wheel, _shaft_on(wheel.side, shaft_of)) for wheel in spec.wheels}
        gyros = {gyro.name: self._build(gyro, GYROS, yaw_rate) for gyro in spec.gyros}
        self._devices: dict[str, EmulatedDevice] = {**rangers, **wheels, **gyros}
        self.buses = {bus.name: self._build_bus(bus) for bus in spec.buses}

    def switch_on(self, now_ns: int) -> None:
        """Give every device power, unless it was given before."""
        for bus in self.buses.values():
            bus.switch_on(now_ns)

    def ports(self, clock: Clock) -> dict[str, MemoryPort[Any, Any]]:
        """A port in memory for every bus by name; the robot is switched on."""
        self.switch_on(clock.now_ns())
        return {name: MemoryPort(bus, clock) for name, bus in self.buses.items()}

    def device(self, name: str) -> EmulatedDevice:
        """The device of that name. Raises UnknownNameError."""
        return _look_up(name, self._devices)

    def fault(self, name: str, verb: str, now_ns: int, for_ns: int | None = None) -> None:
        """Let a device or bus fail. Raises UnknownNameError, UnknownVerbError."""
        self.advance(now_ns)
        _look_up(name, self._fallible()).fault(verb, now_ns, for_ns)

    def clear(self, name: str, now_ns: int) -> None:
        """End the faults of a device or bus. Raises UnknownNameError."""
        self.advance(now_ns)
        _look_up(name, self._fallible()).clear(now_ns)

    def active_faults(self, now_ns: int) -> tuple[ActiveFault, ...]:
        """The faults which last."""
        self.advance(now_ns)
        return tuple(fault for part in self._fallible().values() for fault in part.faults.active())

    def verbs(self) -> dict[str, tuple[str, ...]]:
        """The faults that each device and bus knows."""
        return {name: tuple(part.faults.verbs) for name, part in self._fallible().items()}

    def advance(self, now_ns: int) -> None:
        """Do all that is due by now."""
        for bus in self.buses.values():
            bus.advance(now_ns)

    def next_event_ns(self) -> int:
        """When something is due next; NEVER_NS if nothing is."""
        return min((bus.next_event_ns() for bus in self.buses.values()), default=NEVER_NS)

    def _fallible(self) -> dict[str, Fallible]:
        return {**self._devices, **self.buses}

    def _wheel(self, spec: WheelSpec, shaft: Callable[[int], float]) -> EmulatedDevice:
        """The controller of a wheel that may slip."""
        slipping = SlippingShaft(Shaft.of(shaft))
        angle: Callable[[int], float] = slipping
        device = self._build(spec, WHEELS, angle)
        device.faults.add("slip", Verb(slipping.lose_grip, slipping.grip))
        return device

    def _build(
        self, part: RangerSpec | WheelSpec | GyroSpec, models: Mapping[str, Model[Sensed]], sensed: Sensed
    ) -> EmulatedDevice:
        model = models.get(part.model)
        if model is None:
            raise RobotSpecError(f"{part.name}: no model {part.model!r}{did_you_mean(part.model, models)}")
        kinds = {bus.name: bus.kind for bus in self.spec.buses}
        if part.bus not in kinds:
            raise RobotSpecError(f"{part.name}: no bus {part.bus!r}{did_you_mean(part.bus, kinds)}")
        if kinds[part.bus] != model.bus_kind:
            raise RobotSpecError(
                f"{part.name}: {part.model} needs a {model.bus_kind} bus, {part.bus} is {kinds[part.bus]}"
            )
        return model.build(part.name, sensed, Random(f"{self._seed}/{part.name}"), part.options)

    def _build_bus(self, spec: BusSpec) -> SerialLine | CanBus | I2cBus | IioBus:
        kinds = (self.spec.rangers, self.spec.wheels, self.spec.gyros)
        places = [(part.name, part.bus) for parts in kinds for part in parts]
        devices = [self._devices[name] for name, bus in places if bus == spec.name]
        if spec.kind == "can":
            nodes = [device for device in devices if isinstance(device, CanNode)]
            return CanBus(spec.name, spec.rate or _CAN_RATE, nodes)
        if spec.kind == "i2c":
            chips = [device for device in devices if isinstance(device, I2cChip)]
            return _i2c_bus(spec, chips)
        if spec.kind == "serial":
            return _serial_line(spec, [device for device in devices if isinstance(device, SerialDevice)])
        if spec.kind == "iio":
            return _iio_bus(spec, [device for device in devices if isinstance(device, IioDevice)])
        raise RobotSpecError(f"{spec.name}: no kind of bus {spec.kind!r} (there are: can, i2c, iio, serial)")


def _shaft_on(side: str, shaft_of: Callable[[str], Callable[[int], float]]) -> Callable[[int], float]:
    if side not in _SIDES:
        raise RobotSpecError(f"no wheel on the side {side!r} (there are: {', '.join(_SIDES)})")
    return shaft_of(side)


def _require_names(spec: RobotSpec) -> None:
    seen: set[str] = set()
    kinds = (spec.buses, spec.rangers, spec.wheels, spec.gyros)
    for name in [part.name for parts in kinds for part in parts]:
        if not _NAME.fullmatch(name):
            raise RobotSpecError(f"{name!r} is not a name (letters, digits, '_', '-'; not \"control\")")
        if name in seen:
            raise RobotSpecError(f"{name}: two parts of this name (rename one, buses count too)")
        seen.add(name)


def _i2c_bus(spec: BusSpec, chips: list[I2cChip]) -> I2cBus:
    owners: dict[int, str] = {}
    for chip in chips:
        other = owners.setdefault(chip.address, chip.name)
        if other != chip.name:
            raise RobotSpecError(f"{spec.name}: {other} and {chip.name} share address {chip.address:#x}")
    return I2cBus(spec.name, spec.rate or _I2C_RATE, chips)


def _iio_bus(spec: BusSpec, rangers: list[IioDevice]) -> IioBus:
    owners: dict[str, str] = {}
    for ranger in rangers:
        other = owners.setdefault(ranger.device, ranger.name)
        if other != ranger.name:
            raise RobotSpecError(f"{spec.name}: {other} and {ranger.name} share the device {ranger.device!r}")
    return IioBus(spec.name, rangers)


def _serial_line(spec: BusSpec, devices: list[SerialDevice]) -> SerialLine:
    if not devices:
        raise RobotSpecError(f"{spec.name}: a serial line without a device")
    for device in devices:
        if len(devices) > 1 and not device.shares_line:
            raise RobotSpecError(f"{spec.name}: {device.name} talks unasked, and needs a line of its own")
        if spec.rate not in (None, device.baud):
            raise RobotSpecError(f"{spec.name}: {device.name} speaks at {device.baud} baud, not {spec.rate}")
        if device.baud != devices[0].baud:
            raise RobotSpecError(f"{spec.name}: {device.name} and {devices[0].name} differ in their baud")
    return SerialLine(spec.name, *devices)


def _look_up(name: str, parts: Mapping[str, Part]) -> Part:
    if name not in parts:
        raise UnknownNameError(f"no device or bus {name!r}{did_you_mean(name, parts)}")
    return parts[name]
