"""Drivers by name, imported when asked for."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from difflib import get_close_matches
from importlib.metadata import EntryPoint, entry_points
from typing import Any, Protocol, cast

from echogrid.drivers.device import BusLine, Device
from echogrid.drivers.errors import UnknownDriverError

GROUP = "echogrid.devices"
"""The entry points with which other packages add theirs: name = "module:Class"."""

BUILT_IN: Mapping[str, str] = {
    "a02yyuw": "echogrid.drivers.a02yyuw:A02yyuw",
    "ak-servo": "echogrid.drivers.ak_servo:AkServo",
    "cia402": "echogrid.drivers.cia402:Cia402Axis",
    "dbc": "echogrid.drivers.dbc_wheel:DbcWheel",
    "dyp-rs485": "echogrid.drivers.dyp_rs485:DypRs485",
    "ff-on-demand": "echogrid.drivers.ff_on_demand:FfOnDemand",
    "gyro-dbc": "echogrid.drivers.gyro_dbc:GyroDbc",
    "gyro-text": "echogrid.drivers.gyro_text:GyroText",
    "i2cxl": "echogrid.drivers.i2cxl:I2cxl",
    "iio": "echogrid.drivers.iio:Iio",
    "maxbotix": "echogrid.drivers.maxbotix:Maxbotix",
    "moteus": "echogrid.drivers.moteus:Moteus",
    "odrive-0.5": "echogrid.drivers.odrive:ODriveAxis",
    "odrive-0.6": "echogrid.drivers.odrive06:ODrive06Axis",
    "rcwl-9620": "echogrid.drivers.rcwl9620:Rcwl9620",
    "roboteq": "echogrid.drivers.roboteq:Roboteq",
    "srf01": "echogrid.drivers.srf01:Srf01",
    "srf02": "echogrid.drivers.srf02:Srf02",
    "srf02-serial": "echogrid.drivers.srf02_serial:Srf02Serial",
    "srf08": "echogrid.drivers.srf08:Srf08",
    "srf10": "echogrid.drivers.srf10:Srf10",
    "srf235": "echogrid.drivers.srf235:Srf235",
    "urm07": "echogrid.drivers.urm07:Urm07",
    "urm09": "echogrid.drivers.urm_i2c:Urm09",
    "urm12": "echogrid.drivers.urm_modbus:Urm12",
    "urm13": "echogrid.drivers.urm_modbus:Urm13",
    "urm13-i2c": "echogrid.drivers.urm_i2c:Urm13I2c",
    "urm14": "echogrid.drivers.urm_modbus:Urm14",
    "urm15": "echogrid.drivers.urm_modbus:Urm15",
    "urm37": "echogrid.drivers.urm37:Urm37",
    "vesc": "echogrid.drivers.vesc:Vesc",
}


class Driver(Protocol):
    """A device's class."""

    @property
    def bus(self) -> str:
        """The kind of its port: "serial", "i2c", "can" or "iio"."""
        ...

    @property
    def line(self) -> Callable[[str, Sequence[Any]], BusLine[Any, Any]]:
        """Makes a line of a bus's name and the devices on it; all devices on a bus must have the same."""
        ...

    @property
    def identity(self) -> str:
        """The key of its Settings that no other on its bus may share, such as its address; or ""."""
        ...

    @property
    def port_options(self) -> Mapping[str, object]:
        """What its port should be opened with, unless the user says otherwise."""
        ...

    @property
    def Settings(self) -> type:  # noqa: N802 - it is a class
        """The frozen dataclass of its keys in a config file; raises ValueError on impossible values."""
        ...

    def __call__(self, role: Any, settings: Any) -> Device[Any, Any]:
        """A device for that role (RangerRole, WheelRole or GyroRole) with these Settings."""
        ...


def driver(name: str) -> Driver:
    """The driver of that name. Raises UnknownDriverError, with a hint."""
    known = _entries()
    if name not in known:
        raise UnknownDriverError(f"unknown driver {name!r}{_hint(name, known)}")
    try:
        return cast(Driver, known[name].load())
    except (ImportError, AttributeError) as error:
        raise UnknownDriverError(f"driver {name!r}: cannot load {known[name].value}: {error}") from error


def driver_names() -> tuple[str, ...]:
    """Every driver there is, sorted."""
    return tuple(sorted(_entries()))


def _entries() -> dict[str, EntryPoint]:
    """Those of other packages, under those built in."""
    others = {entry.name: entry for entry in entry_points(group=GROUP)}
    return others | {name: EntryPoint(name, value, GROUP) for name, value in BUILT_IN.items()}


def _hint(name: str, known: Iterable[str]) -> str:
    close = get_close_matches(name, known, n=1, cutoff=0.5)
    return f" (did you mean {close[0]!r}?)" if close else f": expected one of {', '.join(sorted(known))}"
