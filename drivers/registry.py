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
    "odrive-0.5": "echogrid.drivers.odrive:ODriveAxis",
    "srf08": "echogrid.drivers.srf08:Srf08",
}


class Driver(Protocol):
    """A device's class."""

    @property
    def bus(self) -> str:
        """The kind of its port: "serial", "i2c" or "can"."""
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
        """A device for that role (RangerRole or WheelRole) with these Settings."""
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
