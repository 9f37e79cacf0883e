"""A ranger is given another address: looked at before, changed, and looked at again."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from echogrid.drivers import registry
from echogrid.drivers.clock import Clock
from echogrid.drivers.device import Health, State
from echogrid.drivers.errand import Errand
from echogrid.drivers.errors import EchogridError
from echogrid.drivers.readdress import READDRESSED, change
from echogrid.drivers.readings import Outcome, RangeReading, Reading
from echogrid.runtime import lone_device
from echogrid.runtime.config import Config
from echogrid.runtime.errors import UsageError
from echogrid.runtime.lines import line_of
from echogrid.runtime.lone_bus import LoneBus, lone_bus
from echogrid.runtime.ports import real_ports
from echogrid.runtime.reading_text import said
from echogrid.runtime.toml_values import hint

_LOOK_S = 4.0
"""For a device to bring readings."""
_ENOUGH = 2
"""Readings that prove it: the first ones of another make may look right."""
_GLANCE_S = 0.2
_NOBODY = (State.MISSING, State.SETTING_UP)
_SETTLED = (State.WRONG_DEVICE, State.CONFLICT)
"""No wait makes these better."""
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
        """What is at the old address. Raises ReaddressError if it is not the device, or the new is taken."""
        told = self._look(self._old)
        if not told.reading:
            raise ReaddressError(f"{self._port}: no {self._driver} at {self._old:#04x}: {told.trouble}")
        if not self._is_free(self._new):
            raise ReaddressError(
                f"{self._port}: there is a device at {self._new:#04x} already: choose another"
            )
        return f"{self._port}: {self._driver} at {self._old:#04x} says {told.reading}"

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
        told = self._look(self._new)
        if not told.reading:
            raise ReaddressError(f"{self._port}: no {self._driver} at {self._new:#04x}: {told.trouble}")
        if not self._is_free(self._old):
            raise ReaddressError(f"{self._port}: somebody is still at {self._old:#04x}: were there two?")
        return f"{self._driver} at {self._new:#04x} says {told.reading}"

    def _config(self, address: int) -> Config:
        identity = registry.driver(self._driver).identity
        return lone_device.on_port(self._driver, self._port, {**self._settings, identity: address})

    def _look(self, address: int) -> "_Told":
        """What the driver says of the device at an address, as soon as it is sure."""
        with lone_device.opened(self._config(address), Path(), self._clock) as bus:
            health = self._health(bus)
            until_ns = self._clock.now_ns() + round(_LOOK_S * 1e9)
            while self._clock.now_ns() < until_ns and health.state not in _SETTLED:
                if bus.turn_until(lambda: bus.waiting >= _ENOUGH, _GLANCE_S):
                    sane = [each for each in bus.take() if not _doubtful(each)]
                    if len(sane) >= _ENOUGH and self._health(bus).state is State.WELL:
                        return _Told(said(sane[-1]), "")
                health = self._health(bus)
        return _Told("", health.message)

    def _is_free(self, address: int) -> bool:
        """Whether nobody answers there, of whatever make."""
        with lone_device.opened(self._config(address), Path(), self._clock) as bus:
            bus.turn_until(lambda: self._health(bus).state not in _NOBODY, _ABSENT_S)
            return self._health(bus).state is State.MISSING

    def _health(self, bus: LoneBus) -> Health:
        return bus.pump.line.devices[0].health(self._clock.now_ns())


@dataclass(frozen=True, slots=True)
class _Told:
    """What was learnt of an address."""

    reading: str
    """What the device measures; empty unless it is well."""
    trouble: str
    """Why it is not."""


def _doubtful(reading: Reading) -> bool:
    return isinstance(reading, RangeReading) and reading.outcome is Outcome.INVALID
