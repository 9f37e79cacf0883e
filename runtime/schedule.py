"""What can be told of a firing plan beforehand: how often each ranger fires, what it may hear of others."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import degrees, pi
from typing import Any

from echogrid.drivers.role import Call, Slot
from echogrid.drivers.sound import speed_of_sound
from echogrid.runtime.config import Config
from echogrid.runtime.firing import Plan
from echogrid.runtime.firing_groups import angle_between
from echogrid.runtime.firing_patterns import AUDIBLE_NS
from echogrid.runtime.firing_times import Pinger, worst_gap_ns

WITHIN = pi / 2
"""rad: rangers which look less than that apart hear each other by one wall."""
_ROUNDING = 1e-9
Band = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Window:
    """What a ranger may hear of another one."""

    listener: str
    source: str
    bands: tuple[Band | None, ...]
    """m: from where it seems to come, in each cycle of the rotation; None: it comes too early or too late."""


def pings_per_s(plan: Plan) -> float:
    """Of all rangers which fire when they are told to, without the turns in which they only listen."""
    parts = (1.0 - 1.0 / slot.listens_every if slot.listens_every else 1.0 for slot in plan.slots.values())
    return sum(parts) * 1e9 / plan.period_ns if plan.period_ns else 0.0


def by_themselves(config: Config, plan: Plan) -> list[str]:
    """The rangers which the plan leaves out."""
    return [sensor.name for sensor in config.sensor if sensor.name not in plan.slots]


def windows(config: Config, plan: Plan) -> Iterator[Window]:
    """Who may hear whom: those which look at one wall, if the sound comes in while they listen."""
    speed = speed_of_sound(config.robot.air_temperature_c)
    for listener in plan.pingers:
        for source in plan.pingers:
            if (
                source is not listener
                and angle_between(listener.bearing, source.bearing) < WITHIN - _ROUNDING
            ):
                window = _window(plan, listener, source, speed)
                if any(window.bands):
                    yield window


def _window(plan: Plan, listener: Pinger, source: Pinger, speed: float) -> Window:
    own, other = plan.slots[listener.name], plan.slots[source.name]
    bands = (_band(own, other, number, listener.reach, speed) for number in range(len(own.delays_ns)))
    return Window(listener.name, source.name, tuple(bands))


def _band(own: Slot, other: Slot, number: int, reach: float, speed: float) -> Band | None:
    """r = (c/2) (L/c + t_tx - t_rx), for ways L from 0 to the longest that is audible."""
    found: list[Band] = []
    for beside in range(number - 2, number + 3):
        lag_ns = other.planned_ns(beside) - own.planned_ns(number)
        nearest, farthest = (0.5e-9 * speed * (lag_ns + way_ns) for way_ns in (0, AUDIBLE_NS))
        if nearest < reach and farthest > 0.0:
            found.append((max(nearest, 0.0), min(farthest, reach)))
    return (min(near for near, _ in found), max(far for _, far in found)) if found else None


def facts(config: Config, plan: Plan) -> dict[str, Any]:
    """All of it, as JSON has it."""
    return {
        "robot": config.robot.name,
        "mode": config.firing.mode,
        "verify": config.firing.verifies,
        "cycle_ms": _ms(plan.period_ns),
        "cycles_per_s": round(1e9 / plan.period_ns, 3) if plan.period_ns else 0.0,
        "pings_per_s": round(pings_per_s(plan), 3),
        "groups": [
            {"begins_ms": _ms(volley.offset_ns), "lasts_ms": _ms(volley.gap_ns), "rangers": [*volley.members]}
            for volley in plan.volleys
        ],
        "rangers": [_ranger(plan, pinger) for pinger in plan.pingers],
        "by_themselves": by_themselves(config, plan),
        "crosstalk": [
            {
                "listener": window.listener,
                "source": window.source,
                "bands_m": [band and [round(edge, 3) for edge in band] for band in window.bands],
            }
            for window in windows(config, plan)
        ],
    }


def _ranger(plan: Plan, pinger: Pinger) -> dict[str, Any]:
    slot = plan.slots[pinger.name]
    return {
        "name": pinger.name,
        "bearing_deg": round(degrees(pinger.bearing), 3),
        "begins_ms": _ms(slot.offset_ns),
        "delays_ms": [_ms(delay_ns) for delay_ns in slot.delays_ns],
        "jitter_ms": _ms(slot.jitter_ns),
        "listens_every": slot.listens_every,
        "call": plan.calls.get(pinger.name, Call.ITSELF).value,
        "ping_ms": _ms(pinger.pace.ping_ns),
        "worst_gap_ms": _ms(worst_gap_ns(slot)),
    }


def _ms(time_ns: int) -> float:
    return round(time_ns * 1e-6, 3)
