"""Which rangers hang on the machine's ports: I2C by their registers, serial ones by listening.

Nothing is sent that lets a device do something, unless it is asked for.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from echogrid.drivers import i2c_scan, registry
from echogrid.drivers.bus import I2cTransfer
from echogrid.drivers.clock import Clock
from echogrid.drivers.conversation import Conversation
from echogrid.drivers.device import Line, State
from echogrid.drivers.errand import Errand
from echogrid.drivers.errors import PortError, UnknownDriverError
from echogrid.drivers.readings import Outcome, RangeReading
from echogrid.drivers.role import RangerRole
from echogrid.drivers.transports.ports import make_port
from echogrid.drivers.yaw_gyro import is_for_gyros
from echogrid.runtime import lone_device
from echogrid.runtime.errors import UsageError
from echogrid.runtime.lone_bus import lone_bus
from echogrid.runtime.reading_text import said

_LOOK_S = 5.0
"""For all addresses of an I2C bus."""
_LISTEN_S = 1.2
"""At one speed; the slowest rangers send once in 0.7 s."""
_ASK_S = 1.5
"""For one driver to bring a reading."""
_ENOUGH = 2
"""Readings that prove a ranger: noise may look like one."""
_SOCKET = "unix:"
_IIO = Path("/sys/bus/iio/devices")
_ROLE = RangerRole("scan", 0.0, lone_device.FARTHEST_M, None, 343.2)


@dataclass(frozen=True, slots=True)
class Found:
    """A device, or what can be said of one."""

    port: str
    drivers: tuple[str, ...]
    """Those which it may be; none: an unknown device."""
    address: int | None
    settings: dict[str, Any]
    """What the driver must be told to talk to it."""
    reading: str = ""
    """What it said."""


@dataclass(frozen=True, slots=True)
class _Listener:
    """A driver that hears what comes in."""

    driver: str
    settings: dict[str, Any]
    device: Any


def machine_ports() -> list[str]:
    """The ports of this machine on which rangers may be."""
    serial = ("ttyUSB*", "ttyACM*", "ttyAMA*", "serial0")
    buses = sorted(Path("/dev").glob("i2c-*"))
    lines = [path for pattern in serial for path in sorted(Path("/dev").glob(pattern))]
    kernel = [_IIO] if any(_IIO.glob("iio:device*")) else []
    return [str(path) for path in (*buses, *lines, *kernel)]


def scan(port: str, asks: bool, clock: Clock, tell: Callable[[str], None]) -> Iterator[Found]:
    """What is on a port; `tell` is given a line on what takes long, and on what was not found.

    Raises PortError if it does not open.
    """
    if Path(port).is_dir():
        yield from _by_the_kernel(Path(port))
    elif port.startswith((_SOCKET, "/dev/i2c-")):
        for found in _on_i2c(port, clock):
            yield _asked(found, clock) if asks else found
    else:
        yield from _on_serial(port, asks, clock, tell)


def _by_the_kernel(folder: Path) -> Iterator[Found]:
    """The kernel's own rangers, by the names of their drivers."""
    for device in sorted(folder.glob("iio:device*")):
        name = (device / "name").read_text().strip() if (device / "name").exists() else ""
        if (device / "in_distance_raw").exists():
            yield Found(str(folder), ("iio",), None, {"device": name or device.name})


def _on_serial(port: str, asks: bool, clock: Clock, tell: Callable[[str], None]) -> Iterator[Found]:
    """What talks on a line is heard, and not spoken to."""
    found = list(_heard(port, clock, tell))
    yield from found
    if found:
        return
    if not asks:
        tell("nothing known was heard; --ask speaks to rangers which wait to be spoken to")
        return
    tell("nothing known was heard; now asking, by every driver in turn (some 15 s)")
    yield from _answering(port, clock)


def _on_i2c(port: str, clock: Clock) -> Iterator[Found]:
    def course(errand: Errand[I2cTransfer, tuple[i2c_scan.Sighting, ...]]) -> Any:
        return i2c_scan.look_twice(lambda: errand.now_ns)

    errand = Errand(course, I2cTransfer(()), {})
    with lone_bus(Line(port, [errand]), make_port("i2c", port), clock) as bus:
        bus.turn_until(lambda: errand.done, _LOOK_S)
    for sighting in sorted(errand.outcome or (), key=lambda each: each.address):
        yield Found(port, sighting.drivers, sighting.address, {"address": sighting.address})


def _asked(found: Found, clock: Clock) -> Found:
    """The same, after one ping by each driver that it may be: the first which understands it is the one."""
    for driver in found.drivers:
        if words := _said(driver, found.port, found.settings, clock):
            return Found(found.port, (driver,), found.address, found.settings, words)
    return found


def _heard(port: str, clock: Clock, tell: Callable[[str], None]) -> Iterator[Found]:
    """Rangers which send unasked: all such drivers listen at once, at one speed after the other."""
    for baud, listeners in _listeners().items():
        readings = _listened(port, baud, listeners, clock)
        states = {listener.device.health(clock.now_ns()).state for listener in listeners}
        if not readings and State.SILENT not in states:
            tell(f"bytes at {baud} baud, but no frames that are known: another speed, or inverted?")
        for listener in listeners:
            own = [each for each in readings if each.sensor == listener.device.name]
            if len(own) >= _ENOUGH and (words := _told(own)):
                assumed = f"{words}, if so" if listener.settings else words
                yield Found(port, (listener.driver,), None, listener.settings, assumed)
                return


def _listened(port: str, baud: int, listeners: list[_Listener], clock: Clock) -> list[RangeReading]:
    """What they understand of a line at one speed."""
    line = Line(port, [listener.device for listener in listeners])
    with lone_bus(line, make_port("serial", port, {"baud": baud}), clock) as bus:
        bus.turn_until(lambda: bus.waiting >= _ENOUGH, _LISTEN_S)
        return [each for each in bus.take() if isinstance(each, RangeReading)]


def _answering(port: str, clock: Clock) -> Iterator[Found]:
    """Rangers which speak when they are spoken to, each driver at its usual address."""
    for name, driver in _drivers():
        spoken_to = driver.bus == "serial" and driver.line is Conversation
        if spoken_to and (words := _said(name, port, {}, clock)):
            address = getattr(driver.Settings(), driver.identity, None) if driver.identity else None
            yield Found(port, (name,), address, {}, words)


def _said(driver: str, port: str, settings: dict[str, Any], clock: Clock) -> str:
    """What a device says to its driver; empty if they don't understand each other."""
    try:
        config = lone_device.on_port(driver, port, settings)
        with lone_device.opened(config, Path(), clock) as bus:
            bus.turn_until(lambda: bus.waiting >= 1, _ASK_S)
            return _told(bus.take())
    except (PortError, UsageError):
        return ""


def _told(readings: Sequence[Any]) -> str:
    """The last reading that makes sense, in words."""
    ranges = [each for each in readings if isinstance(each, RangeReading)]
    believed = [each for each in ranges if each.outcome is not Outcome.INVALID]
    if not believed:
        return ""
    return said(believed[-1])


def _drivers() -> Iterator[tuple[str, registry.Driver]]:
    """All that can be loaded: one of another package that can't must not spoil the scan."""
    for name in registry.driver_names():
        with suppress(UnknownDriverError):
            yield name, registry.driver(name)


def _listeners() -> dict[int, list[_Listener]]:
    """Drivers which only listen, with the settings that are likely, by the speed at which they do."""
    by_baud: dict[int, list[_Listener]] = {}
    for name, driver in _drivers():
        if driver.bus == "serial" and driver.line is Line and not is_for_gyros(driver):
            likely: tuple[dict[str, Any], ...] = getattr(driver, "likely", ({},))
            for settings in likely:
                role = replace(_ROLE, name=f"{name} {settings}")
                listener = _Listener(name, settings, driver(role, driver.Settings(**settings)))
                by_baud.setdefault(int(listener.device.port_options["baud"]), []).append(listener)
    return by_baud
