"""bench.toml: which real devices there are, and at which ports."""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pytest import skip

from echogrid.drivers.bus import Port
from echogrid.drivers.errors import PortError
from echogrid.drivers.transports.ports import make_port

KINDS = {"a02yyuw": "serial", "srf08": "i2c", "odrive": "can"}


@dataclass(frozen=True, slots=True)
class Entry:
    """A device on the bench."""

    device: str
    port: str
    options: Mapping[str, Any]
    """Of the port."""
    facts: Mapping[str, Any]
    """What else is known: address or node, and the truth that it measures."""

    def opened(self) -> Port[Any, Any]:
        """Its port, open. Skips the test, and says so, if the device is not there."""
        port = make_port(KINDS[self.device], self.port, self.options)
        try:
            port.open()
        except PortError as error:
            skip(str(error))
        return port

    def fact(self, name: str) -> float:
        """Something that is true of it. Skips the test, and says so, if nobody knows."""
        if name not in self.facts:
            skip(f"[{self.device}] does not say its {name}")
        return float(self.facts[name])


class Bench:
    """The devices by name."""

    def __init__(self, source: str, devices: Mapping[str, Mapping[str, Any]]) -> None:
        """Raises ValueError for a device that no test knows, or one without a port."""
        for name, table in devices.items():
            if name not in KINDS:
                raise ValueError(f"{source}: [{name}] is none of {', '.join(sorted(KINDS))}")
            if "port" not in table:
                raise ValueError(f"{source}: [{name}] has no `port`")
        self._source = source
        self._devices = devices

    @classmethod
    def load(cls, path: Path) -> "Bench":
        """From a file."""
        return cls(str(path), tomllib.loads(path.read_text(encoding="utf-8")))

    def entry(self, device: str) -> Entry:
        """A device. Skips the test, and says so, if the bench has none."""
        if device not in self._devices:
            skip(f"{self._source} names no [{device}]")
        facts = dict(self._devices[device])
        return Entry(device, facts.pop("port"), facts.pop("options", {}), facts)
