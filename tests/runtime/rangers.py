"""Every ranger that there is a driver for: what the two suites over all of them must know of each."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from echogrid.drivers.device import State
from echogrid.drivers.readings import Outcome

from .device_trial import Subject

WELL, FAULTY, SILENT, STALLED = State.WELL, State.FAULTY, State.SILENT, State.STALLED
MISSING, GARBLED, CONFLICT, LOST = State.MISSING, State.GARBLED, State.CONFLICT, State.PORT_LOST
OTHER = State.WRONG_DEVICE

VERBS = (
    *("off", "stuck", "garbage", "wrong", "slow", "delayed", "intermittent", "unplug"),
    *("nack_storm", "address_conflict"),
)

Seen = Mapping[str, State | None]
"""Fault -> the state that it mostly shows as; None: it comes and goes."""

COMMON: Seen = {
    "off": MISSING,
    "unplug": MISSING,
    "stuck": WELL,
    "wrong": WELL,
    "garbage": GARBLED,
    "slow": MISSING,
    "delayed": MISSING,
    "intermittent": None,
}
ON_I2C: Seen = {**COMMON, "nack_storm": None, "address_conflict": CONFLICT}
UNASKED: Seen = {**COMMON, "off": SILENT, "unplug": LOST, "slow": WELL, "delayed": WELL}
"""They send on and on: that it is late, or seldom, nothing shows."""
ON_LINE: Seen = {**COMMON, "unplug": LOST, "address_conflict": GARBLED}
ON_MODBUS: Seen = {**COMMON, "unplug": LOST, "slow": WELL, "nack_storm": FAULTY}


@dataclass(frozen=True, slots=True)
class Ranger:
    """A row."""

    subject: Subject
    resolution: float
    """m: half of the step in which it tells distances, and what its clock adds."""
    seen: Seen
    """What its faults look like; it has no others."""
    distances: tuple[float, ...] = (0.4, 0.8, 1.2, 2.4)
    """m, of walls which it must see."""
    nothing: Outcome | None = field(default=Outcome.NO_ECHO, kw_only=True)
    """What it says of nothing; None: it is silent."""
    thermometer: bool = field(default=False, kw_only=True)
    """Whether its distances are true at any temperature by itself."""


RANGERS: dict[str, Ranger] = {
    "srf02": Ranger(Subject("srf02"), 0.0003, ON_I2C),
    # A twin of which every bit of the revision stands does not show.
    "srf08": Ranger(Subject("srf08"), 0.0003, {**ON_I2C, "address_conflict": WELL}),
    "srf10": Ranger(Subject("srf10"), 0.0003, ON_I2C),
    "srf235": Ranger(Subject("srf235"), 0.0051, {**ON_I2C, "slow": FAULTY}, (0.4, 0.6, 0.8)),
    # It says nothing but a number: two of them pull that down.
    "i2cxl": Ranger(Subject("i2cxl"), 0.0051, {**ON_I2C, "garbage": FAULTY, "address_conflict": WELL}),
    "rcwl-9620": Ranger(
        Subject("rcwl-9620"),
        0.0001,
        {**ON_I2C, "garbage": FAULTY, "slow": WELL, "delayed": WELL, "address_conflict": WELL},
    ),
    "urm09": Ranger(
        Subject("urm09"),
        0.0051,
        {**ON_I2C, "garbage": OTHER, "slow": WELL, "delayed": WELL},
        thermometer=True,
    ),
    "urm13-i2c": Ranger(
        Subject("urm13-i2c"),
        0.0051,
        {**ON_I2C, "garbage": OTHER, "slow": WELL, "delayed": WELL},
        (0.45, 0.8, 1.2, 2.4),
        thermometer=True,
    ),
    "srf02-serial": Ranger(Subject("srf02-serial"), 0.0003, ON_LINE),
    "srf01": Ranger(Subject("srf01"), 0.0051, ON_LINE),
    "urm37": Ranger(
        Subject("urm37"), 0.0051, {**COMMON, "unplug": LOST, "slow": WELL, "delayed": WELL}, thermometer=True
    ),
    "urm07": Ranger(Subject("urm07"), 0.0051, {**ON_LINE, "slow": None}, thermometer=True),
    # Of a pulse on a pin nothing can be told but its length.
    "iio": Ranger(Subject("iio"), 0.001, {**COMMON, "garbage": WELL, "slow": WELL}),
    "urm12": Ranger(Subject("urm12"), 0.0051, ON_MODBUS, (0.8, 1.2, 2.4, 3.6), thermometer=True),
    "urm13": Ranger(
        Subject("urm13"), 0.0051, {**ON_MODBUS, "slow": FAULTY}, (0.5, 0.8, 1.2, 2.4), thermometer=True
    ),
    "urm14": Ranger(Subject("urm14"), 0.0001, ON_MODBUS, (0.4, 0.6, 0.8), thermometer=True),
    "urm15": Ranger(Subject("urm15"), 0.0006, ON_MODBUS, thermometer=True),
    "dyp-rs485": Ranger(Subject("dyp-rs485"), 0.0006, {**ON_MODBUS, "slow": MISSING}, thermometer=True),
    "ff-on-demand": Ranger(
        Subject("ff-on-demand"),
        0.0006,
        {**COMMON, "unplug": LOST, "slow": None, "delayed": None},
        thermometer=True,
    ),
    "maxbotix": Ranger(Subject("maxbotix", {"model": "MB1240"}), 0.0051, UNASKED),
    "a02yyuw": Ranger(Subject("a02yyuw"), 0.0006, UNASKED, thermometer=True),
}
