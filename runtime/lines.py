"""The devices of each bus, as configured: resolved, checked against each other, put together."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import radians
from types import MappingProxyType
from typing import Any

from echogrid.drivers import registry
from echogrid.drivers.commanded import CommandedRanger
from echogrid.drivers.device import BusLine, Departing, Device, Line
from echogrid.drivers.errors import UnknownDriverError
from echogrid.drivers.registry import Driver
from echogrid.drivers.role import Call, GyroRole, RangerRole, Steering, WheelRole
from echogrid.drivers.sound import speed_of_sound
from echogrid.drivers.throttle import Throttle
from echogrid.drivers.yaw_gyro import is_for_gyros
from echogrid.runtime.config import Config
from echogrid.runtime.errors import ConfigError
from echogrid.runtime.firing import Plan, firing_plan
from echogrid.runtime.firing_times import Pinger
from echogrid.runtime.hardware_config import GyroConfig, SensorConfig, WheelConfig
from echogrid.runtime.toml_lines import Place
from echogrid.runtime.toml_values import Problem, structured

I2C_BIT_RATE = 100_000
"""The slowest that is usual; the kernel sets it, and no key of a bus."""


@dataclass(frozen=True, slots=True)
class _Part:
    """One entry with its driver and what that makes of its settings."""

    place: Place
    name: str
    bus: str
    driver: Driver
    role: RangerRole | WheelRole | GyroRole
    settings: Any
    device: Device[Any, Any]

    @property
    def identity(self) -> tuple[str, object]:
        """What tells it from the others on its bus."""
        key = self.driver.identity
        return key, getattr(self.settings, key) if key else None


def lines(
    config: Config,
    throttles: Mapping[str, Throttle] = MappingProxyType({}),
    beacons: Sequence[tuple[str, Device[Any, Any]]] = (),
) -> list[BusLine[Any, Any]]:
    """The devices of each bus. Raises ConfigError with every driver or setting that is wrong.

    `throttles` are those of the wheels that shall be driven, by name; `beacons` are devices that only send,
    each with the CAN bus on which it does.
    """
    problems: list[Problem] = []
    parts = [_with_throttle(part, throttles, problems) for part in _parts(config, problems)]
    first, second, _ = config.robot.wheels
    if {wheel.name for wheel in config.wheel} != {first, second}:
        needed = f"a run needs a [[wheel]] named `{first}` and one named `{second}`"
        problems.append(((), f'{needed} (drive = "{config.robot.drive}")'))
    if problems:
        raise ConfigError(problems)
    attached = {bus.name: [part for part in parts if part.bus == bus.name] for bus in config.bus}
    sending = {name: [device for bus, device in beacons if bus == name] for name in attached}
    return [
        (own[0].driver.line if own else Line)(bus, [*(part.device for part in own), *sending[bus]])
        for bus, own in attached.items()
        if own or sending[bus]
    ]


def line_of(config: Config) -> BusLine[Any, Any]:
    """The line of the only device that is configured. Raises ConfigError if it is wrong."""
    problems: list[Problem] = []
    parts = _parts(config, problems)
    if problems:
        raise ConfigError(problems)
    return parts[0].driver.line(parts[0].bus, [parts[0].device])


def plan_of(config: Config) -> Plan:
    """Who fires when. Raises ConfigError with every driver or setting that is wrong."""
    problems: list[Problem] = []
    parts = _idle_parts(config, problems)
    if problems:
        raise ConfigError(problems)
    return _plan(config, parts)


def _parts(config: Config, problems: list[Problem]) -> list[_Part]:
    """Every entry that is right by itself; what is wrong with the others goes to `problems`.

    If nothing is, the rangers know their turns: when they have those depends on all of them.
    """
    parts = _idle_parts(config, problems)
    if problems:
        return parts
    try:
        plan = _plan(config, parts)
    except ConfigError as error:
        problems += error.found
        return parts
    return [_with_turns(part, plan) for part in parts]


def _idle_parts(config: Config, problems: list[Problem]) -> list[_Part]:
    """The same before anybody knows when to fire; also told is who can't be on a bus with another."""
    parts = list(_single_parts(config, problems))
    problems += _doubles(parts)
    problems += _mixtures(config, parts)
    return parts


def _single_parts(config: Config, problems: list[Problem]) -> Iterator[_Part]:
    speed = speed_of_sound(config.robot.air_temperature_c)
    for index, sensor in enumerate(config.sensor):
        role = RangerRole(sensor.name, sensor.min_m, sensor.max_m, None, speed)
        yield from _part(config, sensor, role, ("sensor", index), problems)
    silent = {bus.name for bus in config.bus if bus.listen_only}
    for index, wheel in enumerate(config.wheel):
        wheel_role = WheelRole(
            wheel.name,
            wheel.gear,
            wheel.fastest_rad_s,
            listen_only=wheel.bus in silent,
            steering=_steering(config, wheel),
        )
        yield from _part(config, wheel, wheel_role, ("wheel", index), problems)
    for index, gyro in enumerate(config.gyro):
        gyro_role = GyroRole(gyro.name, listen_only=gyro.bus in silent)
        yield from _part(config, gyro, gyro_role, ("gyro", index), problems)


def _steering(config: Config, wheel: WheelConfig) -> Steering | None:
    """What there is to know of a wheel that is turned to steer; None if it rolls."""
    if wheel.name != "steering":
        return None
    usual = 80.0 if config.robot.drive == "ackermann" else 180.0
    return Steering(radians(wheel.zero_deg), radians(wheel.most_deg or usual))


def _plan(config: Config, parts: list[_Part]) -> Plan:
    return firing_plan(config, [pinger for part in parts for pinger in _pingers(config, part)])


def _pingers(config: Config, part: _Part) -> Iterator[Pinger]:
    """What a firing plan must know of a part, if that fires when it is told to."""
    device = part.device
    if isinstance(device, CommandedRanger):
        sensor = next(sensor for sensor in config.sensor if sensor.name == part.name)
        baud = device.port_options.get("baud")
        yield Pinger(
            part.name,
            radians(sensor.yaw_deg),
            sensor.max_m,
            part.bus,
            device.pace(baud if isinstance(baud, int) else I2C_BIT_RATE),
            device.can_listen,
            device.obeys_general_call,
        )


def _with_turns(part: _Part, plan: Plan) -> _Part:
    """The part with a device that knows when to fire, if it waits to be told."""
    if not isinstance(part.role, RangerRole) or part.name not in plan.slots:
        return part
    call = plan.calls.get(part.name, Call.ITSELF)
    role = replace(part.role, slot=plan.slots[part.name], call=call)
    return replace(part, role=role, device=part.driver(role, part.settings))


def _with_throttle(part: _Part, throttles: Mapping[str, Throttle], problems: list[Problem]) -> _Part:
    """The part with a device that drives its motor, if it is a wheel's that shall be driven."""
    if not isinstance(part.role, WheelRole) or part.name not in throttles:
        return part
    if part.role.listen_only:
        silent = f"{part.name} can't be driven: bus {part.bus!r} has listen_only = true"
        problems.append(((*part.place, "bus"), silent))
        return part
    role = replace(part.role, throttle=throttles[part.name])
    try:
        device = part.driver(role, part.settings)
    except ValueError as error:
        problems.append((part.place, str(error)))
        return part
    if not isinstance(device, Departing):
        problems.append(((*part.place, "driver"), f"{part.name} can't be driven: its driver only listens"))
    return replace(part, role=role, device=device)


def _part(
    config: Config,
    entry: SensorConfig | WheelConfig | GyroConfig,
    role: RangerRole | WheelRole | GyroRole,
    place: Place,
    problems: list[Problem],
) -> Iterator[_Part]:
    if entry.driver is None or entry.bus is None:
        problems.append((place, f"{entry.name}: `driver` and `bus` are needed to run"))
        return
    try:
        driver = registry.driver(entry.driver)
    except UnknownDriverError as error:
        problems.append(((*place, "driver"), str(error)))
        return
    kind = next(bus.kind for bus in config.bus if bus.name == entry.bus)
    if driver.bus != kind:
        speaks = f"{entry.driver} speaks {driver.bus}, but bus {entry.bus!r} is {kind}"
        problems.append(((*place, "bus"), speaks))
    if is_for_gyros(driver) != isinstance(role, GyroRole):
        table = "[[gyro]]" if is_for_gyros(driver) else "[[sensor]] or [[wheel]]"
        problems.append(((*place, "driver"), f"{entry.driver} is for a {table}"))
        return
    settings, wrong = structured(dict(entry.settings), driver.Settings)
    problems += [((*place, *key), what) for key, what in wrong]
    if wrong:
        return
    try:
        yield _Part(place, entry.name, entry.bus, driver, role, settings, driver(role, settings))
    except ValueError as error:
        problems.append((place, str(error)))


def _doubles(parts: list[_Part]) -> Iterator[Problem]:
    """Devices that would answer for each other: two of one address on a bus, two on one serial line."""
    owners: dict[tuple[str, str, object], str] = {}
    for part in parts:
        key, value = part.identity
        other = owners.setdefault((part.bus, key, value), part.name)
        if other != part.name:
            shown = f"{value:#04x}" if part.driver.bus == "i2c" else value
            same = f"{key} {shown}" if key else "the serial line"
            yield (*part.place, key or "bus"), f"{part.name} and {other} share {same} of bus {part.bus!r}"


def _mixtures(config: Config, parts: list[_Part]) -> Iterator[Problem]:
    """Devices that can't be on one bus: they talk at other speeds, or one of them talks unasked."""
    firsts: dict[str, _Part] = {}
    bit_rates = {bus.name: bus.bit_rate for bus in config.bus}
    for part in parts:
        first, place = firsts.setdefault(part.bus, part), (*part.place, "bus")
        ways, others = dict(part.device.port_options), dict(first.device.port_options)
        if part.driver.bus != first.driver.bus:
            continue  # One of them is on a bus of another kind, and that is told already.
        if part.driver.bus == "serial" and bit_rates[part.bus] not in (None, ways.get("baud")):
            yield place, f"{part.name}: say its `baud` here, not `bit_rate` at the bus alone"
        if part.driver.line is not first.driver.line:
            yield place, f"{part.name} and {first.name} can't share bus {part.bus!r}: one talks unasked"
        elif ways and others and ways != others and not (_alike(ways, others) and bit_rates[part.bus]):
            differ = f"{part.name} and {first.name} differ on bus {part.bus!r}: {ways} and {others}"
            mend = " (set them up alike, and say that `bit_rate` at the bus)"
            yield place, differ + (mend if _alike(ways, others) else "")


def _alike(ways: Mapping[str, object], others: Mapping[str, object]) -> bool:
    """Whether two devices on CAN differ in nothing but the bit rate, which can be set."""
    return {**ways, "bitrate": None} == {**others, "bitrate": None}
