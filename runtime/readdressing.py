"""A ranger is given another address: looked at before, changed, and looked at again."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from echogrid.drivers import registry
from echogrid.drivers.clock import Clock
from echogrid.drivers.errand import Errand
from echogrid.drivers.errors import EchogridError
from echogrid.drivers.readdress import READDRESSED, change
from echogrid.runtime import lone_device
from echogrid.runtime.config import Config
from echogrid.runtime.errors import UsageError
from echogrid.runtime.lines import line_of
from echogrid.runtime.lone_bus import lone_bus
from echogrid.runtime.ports import real_ports
from echogrid.runtime.reading_text import said
from echogrid.runtime.toml_values import hint

_LOOK_S = 4.0
"""For a device to bring a reading."""
_ABSENT_S = 1.0
"""For one that is not there to have been looked for several times."""
_CHANGE_S = 5.0


class ReaddressError(EchogridError):
    """The address could not be changed. The text says what is known of it now."""


class Readdress:
    """One change, step by step."""

    def __init__(
        self, driver: str, port: str, addresses: tuple[int, int], settings: Mapping[str, Any], clock: Clock
    ) -> None:
        """`addresses`: the present one and the new one; `settings`: other keys of the driver.

        Raises UsageError for a driver whose addresses can't be changed, or an address that can't be."""
        if driver not in READDRESSED:
            known = ", ".join(sorted(READDRESSED))
            raise UsageError(
                [f"{driver!r} can't be given an address by echogrid{hint(driver, READDRESSED)}: {known} can"]
            )
        self._way = READDRESSED[driver]
        old, new = addresses
        try:
            self._way.transfers(old, new)
        except ValueError as error:
            raise UsageError([str(error)]) from error
        self._driver, self._port, self._old, self._new = driver, port, old, new
        self._settings = settings
        self._clock = clock

    @property
    def after_power_cycle(self) -> bool:
        """Whether the new address counts only when the device was without power."""
        return self._way.after_power_cycle

    def found(self) -> str:
        """What is at the old address. Raises ReaddressError if that is nothing, or the new one is taken."""
        reading = self._reading(self._old, _LOOK_S)
        if not reading:
            raise ReaddressError(
                f"{self._port}: no {self._driver} answers at {self._old:#04x} (echogrid scan)"
            )
        if self._reading(self._new, _ABSENT_S):
            raise ReaddressError(
                f"{self._port}: there is a device at {self._new:#04x} already: choose another"
            )
        return f"{self._port}: {self._driver} at {self._old:#04x} says {reading}"

    def carry_out(self) -> None:
        """Send the messages. Raises ReaddressError if the device does not take them."""
        config = self._config(self._old)
        device = line_of(config).devices[0]

        def course(_: Errand[Any, str]) -> Any:
            return change(self._way, self._old, self._new)

        first = self._way.transfers(self._old, self._new)[0]
        errand = Errand(course, first, device.port_options)
        line = registry.driver(self._driver).line("port", [errand])
        with lone_bus(line, real_ports(config, [line], Path())[line.name], self._clock) as bus:
            bus.turn_until(lambda: errand.done, _CHANGE_S)
        if errand.outcome != "":
            raise ReaddressError(f"{self._port}: {errand.outcome or 'its bus is held up'}")

    def proof(self) -> str:
        """What is at the new address. Raises ReaddressError unless it is the device, and the old is free."""
        reading = self._reading(self._new, _LOOK_S)
        if not reading:
            raise ReaddressError(f"{self._port}: nobody answers at {self._new:#04x}: look with echogrid scan")
        if self._reading(self._old, _ABSENT_S):
            raise ReaddressError(f"{self._port}: somebody is still at {self._old:#04x}: were there two?")
        return f"{self._driver} at {self._new:#04x} says {reading}"

    def _config(self, address: int) -> Config:
        identity = registry.driver(self._driver).identity
        return lone_device.on_port(self._driver, self._port, {**self._settings, identity: address})

    def _reading(self, address: int, within_s: float) -> str:
        """What the device at an address says; empty if nobody does."""
        with lone_device.opened(self._config(address), Path(), self._clock) as bus:
            bus.turn_until(lambda: bus.waiting > 0, within_s)
            return next((said(reading) for reading in bus.take()), "")
