"""Every motor controller on CAN that there is a driver for: what the tests over all must know of each."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import tau
from pathlib import Path
from random import Random
from statistics import median
from typing import Any, get_type_hints

from echogrid.drivers import registry
from echogrid.drivers.device import Device
from echogrid.drivers.readings import WheelReading
from echogrid.drivers.role import WheelRole
from echogrid.emulation.devices.can_node import CanNode
from echogrid.emulation.devices.shaft import Shaft
from echogrid.emulation.models import WHEELS

DATA = Path(__file__).parents[1] / "data"
NODES = {"left": 1, "right": 2}
RATES = {"left": 3.0, "right": -2.0}
"""rad/s: both directions."""
FASTEST = 30.0
STARTS = 3
"""Among its first readings it may tell that it has just started."""
FLOAT_STEP = 1e-5
"""rad: a float32 within some turns."""
FAR_FLOAT_STEP = 2 * tau
"""rad: two steps of the farthest position that is believed."""


def by_node(node: int) -> Mapping[str, Any]:
    """The settings of a driver that wants no more."""
    return {"node": node}


def counted(per_turn: float, **more: str) -> Callable[[int], Mapping[str, Any]]:
    """Those of one that wants to know the counts of a turn, too."""
    return lambda node: {"node": node, "counts_per_turn": per_turn, **more}


def by_dbc(node: int) -> Mapping[str, Any]:
    """The counts of an ODrive, by its file."""
    return {
        "file": str(DATA / "odrive_counts.dbc"),
        "position": f"Axis{node}_Get_Encoder_Count.Shadow_Count",
        "unit": "counts",
        "counts_per_turn": 8192.0,
    }


@dataclass(frozen=True, slots=True)
class Controller:
    """A row."""

    driver: str
    fineness: float
    """rad: the step in which it tells its angle, within some turns."""
    settings: Callable[[int], Mapping[str, Any]] = by_node
    """The driver's, for a node."""
    model: str = ""
    """The emulated one, if it has another name than the driver."""
    options: Mapping[str, int | float | str] = field(default_factory=dict)
    """Of the emulated one."""
    coarseness: float = 0.0
    """rad: that step where it is widest."""
    to_drive: Mapping[str, Any] = field(default_factory=dict)
    """More settings, if it has a throttle."""

    def made(self, wheel: str, role: WheelRole | None = None) -> Device[Any, Any]:
        """The driver of that wheel's node."""
        driver = registry.driver(self.driver)
        role = role or WheelRole(wheel, fastest=FASTEST)
        more = self.to_drive if role.throttle else {}
        return driver(role, driver.Settings(**self.settings(NODES[wheel]), **more))

    def emulated(self, wheel: str, angle: Callable[[int], float]) -> CanNode:
        """That wheel's node, without power."""
        node = NODES[wheel]
        options = {"node": node, **self.options}
        made = WHEELS[self.model or self.driver].build(wheel, Shaft(angle), Random(node), options)
        assert isinstance(made, CanNode)
        return made


WATCHED = {"watchdog": True}

CONTROLLERS = {
    "odrive-0.5": Controller("odrive-0.5", FLOAT_STEP, coarseness=FAR_FLOAT_STEP, to_drive=WATCHED),
    "odrive-0.5-counts": Controller(
        "odrive-0.5", tau / 8192, counted(8192), options={"counts_per_turn": 8192}, to_drive=WATCHED
    ),
    "odrive-0.6": Controller("odrive-0.6", FLOAT_STEP, coarseness=FAR_FLOAT_STEP, to_drive=WATCHED),
    "vesc": Controller("vesc", tau / 42),
    "ak-servo": Controller("ak-servo", tau / 3600),
    "cia402": Controller("cia402", tau / 4096, counted(4096.0), options={"counts_per_turn": 4096}),
    "moteus": Controller("moteus", 1e-4, coarseness=FAR_FLOAT_STEP),
    "roboteq": Controller("roboteq", tau / 2000, counted(2000.0), options={"counts_per_turn": 2000}),
    "roboteq-variable": Controller(
        "roboteq",
        tau / 2000,
        counted(2000.0, source="variable"),
        options={"counts_per_turn": 2000, "source": "variable"},
    ),
    "dbc": Controller("dbc", tau / 8192, by_dbc, "odrive-0.5", {"counts_per_turn": 8192}),
}


def golden(name: str) -> Path:
    """What candump has recorded of two of them, from power-up on."""
    return DATA / "candump" / f"{name}.log"


def drift(readings: Sequence[WheelReading], rate: float) -> float:
    """By how much more it has turned than at that rate (rad), whatever a few late frames say."""
    off = [reading.angle - rate * (reading.stamp_ns - readings[0].stamp_ns) * 1e-9 for reading in readings]
    third = len(off) // 3
    return median(off[-third:]) - median(off[:third])


def can_wheels() -> set[str]:
    """All drivers of wheels on CAN."""
    made = {name: registry.driver(name) for name in registry.BUILT_IN}
    return {name for name, driver in made.items() if driver.bus == "can" and _takes_wheels(driver)}


def _takes_wheels(driver: Any) -> bool:
    return get_type_hints(driver.__init__)["role"] is WheelRole
