"""Devices read through their ports, as the service reads them."""

import time
from collections.abc import Callable, Sequence
from typing import Any

from echogrid.drivers.a02yyuw import A02yyuw
from echogrid.drivers.bus import Port
from echogrid.drivers.clock import MonotonicClock
from echogrid.drivers.device import Device, Line
from echogrid.drivers.odrive import ODriveAxis
from echogrid.drivers.readings import RangeReading, Reading
from echogrid.drivers.role import RangerRole, WheelRole
from echogrid.drivers.srf08 import Srf08
from echogrid.runtime.pump import Pump

SPEED_OF_SOUND = 343.2
WAIT_S = 20.0


def srf08(address: int = 0x70) -> Srf08:
    """Our driver."""
    role = RangerRole("srf08", 0.03, 6.0, None, SPEED_OF_SOUND)
    return Srf08(role, Srf08.Settings(address=address))


def a02yyuw() -> A02yyuw:
    """Our driver."""
    return A02yyuw(RangerRole("a02yyuw", 0.03, 4.5, None, SPEED_OF_SOUND), A02yyuw.Settings())


def odrive(name: str = "wheel", node: int = 0) -> ODriveAxis:
    """Our driver."""
    return ODriveAxis(WheelRole(name), ODriveAxis.Settings(node=node))


class Readout:
    """Devices on a port, and what they have read so far."""

    def __init__(self, port: Port[Any, Any], *devices: Device[Any, Any]) -> None:
        self.readings: list[Reading] = []
        self.pump = Pump(Line("bench", devices), port, MonotonicClock(), self.readings.extend)

    def until(self, done: Callable[[Sequence[Reading]], bool], what: str) -> list[Reading]:
        """Read on until the readings since the call are enough. Raises AssertionError after a while."""
        self.readings.clear()
        give_up = time.monotonic() + WAIT_S
        while not done(self.readings):
            state = [str(device.health(time.monotonic_ns())) for device in self.pump.line.devices]
            assert time.monotonic() < give_up, f"{what}: {self.pump.trouble} {state} {self.readings[-5:]}"
            self.pump.turn()
        return list(self.readings)

    def take(self, count: int) -> list[Reading]:
        """So many readings."""
        return self.until(lambda readings: len(readings) >= count, f"{count} readings")

    def ranges(self, count: int) -> list[RangeReading]:
        """So many readings of rangers."""
        return [reading for reading in self.take(count) if isinstance(reading, RangeReading)]

    def close(self) -> None:
        """Let the port go."""
        self.pump.close()
