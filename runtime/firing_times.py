"""When the groups of a firing plan have their turns, and how long a cycle is: what sound and devices need."""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import ceil

from echogrid.drivers.pace import Pace
from echogrid.drivers.sound import speed_of_sound
from echogrid.runtime.config import Config
from echogrid.runtime.errors import ConfigError
from echogrid.runtime.firing_patterns import Seat, delays

MILLISECOND_NS = 1_000_000
RING_DOWN_NS = 8 * MILLISECOND_NS
"""After the last echo that is asked for: 5 to 10 ms until the sound has died away."""
SLACK_NS = 3 * MILLISECOND_NS
"""How late a turn may be without the ranger missing the next."""
CYCLE_NS = 100 * MILLISECOND_NS
"""In which all fire once, where they can, unless they fire in groups."""
_SPREAD = 4.0
"""Delays change by the time in which sound goes this many times the agreement. What is heard of others moves
by half of that way: twice as far as readings may differ."""


@dataclass(frozen=True, slots=True)
class Pinger:
    """A ranger which fires when it is told to."""

    name: str
    bearing: float
    """rad, of its axis in base_link."""
    reach: float
    """m, that is asked of it."""
    bus: str
    pace: Pace
    can_listen: bool = False
    obeys_general_call: bool = False


Group = tuple[Pinger, ...]


@dataclass(frozen=True, slots=True)
class Timing:
    """Times in the cycle, ns."""

    period_ns: int
    offsets_ns: tuple[int, ...]
    """Of the groups."""
    delays_ns: Mapping[str, tuple[int, ...]] = field(default_factory=dict)


def in_groups(config: Config, groups: Sequence[Group]) -> Timing:
    """Group after group, as soon as the sound of the one has died and its members have answered."""
    firing, speed = config.firing, speed_of_sound(config.robot.air_temperature_c)
    answered = [_busy_ns(group) for group in groups]
    jitter_ns = round(firing.jitter_ms * MILLISECOND_NS)
    cycle_ns = _cycle_ns(groups) + jitter_ns
    if firing.gap_ms is None:
        gaps = [
            max(busy_ns, _silent_ns(group, speed)) for busy_ns, group in zip(answered, groups, strict=True)
        ]
        missing_ns = max(0, cycle_ns - sum(gaps) - jitter_ns)
        gaps = [gap_ns + -(-missing_ns // len(groups)) for gap_ns in gaps]
    else:
        least_ns = max(*answered, -(-(cycle_ns - jitter_ns) // len(groups)))
        gaps = [round(firing.gap_ms * MILLISECOND_NS)] * len(groups)
        if gaps[0] < least_ns:
            why = "until all have answered, and may fire again"
            raise wrong("gap_ms", f"it takes {milliseconds(least_ns)} ms {why}: give as much at least")
    offsets = [sum(gaps[:number]) for number in range(len(groups))]
    return Timing(sum(gaps) + jitter_ns, tuple(offsets))


def in_cycle(config: Config, groups: Sequence[Group]) -> Timing:
    """All in one cycle, which the groups share evenly."""
    firing = config.firing
    asked_ns = CYCLE_NS if firing.cycle_ms is None else round(firing.cycle_ms * MILLISECOND_NS)
    least_ns = _cycle_ns(groups) + round(firing.jitter_ms * MILLISECOND_NS)
    timing = _shared(config, groups, max(asked_ns, least_ns))
    least_ns += max(map(max, timing.delays_ns.values()), default=0)
    if least_ns > asked_ns and firing.cycle_ms is not None:
        why = "until all have answered, and may fire again"
        raise wrong("cycle_ms", f"it takes {milliseconds(least_ns)} ms {why}: give as much at least")
    return timing if least_ns <= timing.period_ns else _shared(config, groups, least_ns)


def _shared(config: Config, groups: Sequence[Group], period_ns: int) -> Timing:
    """A cycle of that length, with the delays that it takes to tell the rangers apart. Raises ConfigError."""
    offsets = tuple(number * period_ns // len(groups) for number in range(len(groups)))
    if config.firing.mode == "together":
        return Timing(period_ns, offsets)
    seats = {
        pinger.name: Seat(offset_ns, pinger.bus, pinger.pace.held_ns)
        for offset_ns, group in zip(offsets, groups, strict=True)
        for pinger in group
    }
    speed = speed_of_sound(config.robot.air_temperature_c)
    step_ns = round(_SPREAD * config.firing.agreement_m / speed * 1e9)
    found = delays(tuple(seats.values()), period_ns, step_ns)
    if found is None:
        raise wrong("mode", 'no delays tell so many rangers apart on these buses: use "groups"')
    return Timing(period_ns, offsets, dict(zip(seats, found, strict=True)))


def _cycle_ns(groups: Sequence[Group]) -> int:
    """The shortest cycle in which every ranger is ready again, and every bus has carried all."""
    buses: defaultdict[str, int] = defaultdict(int)
    for pinger in (pinger for group in groups for pinger in group):
        buses[pinger.bus] += pinger.pace.held_ns + pinger.pace.collect_ns
    ready_ns = max(pinger.pace.period_ns for group in groups for pinger in group)
    return max(ready_ns, *buses.values(), *map(_busy_ns, groups)) + SLACK_NS


def _busy_ns(group: Group) -> int:
    """From a group's turn until all of it have answered: on one bus they do so one after the other."""
    buses: defaultdict[str, list[Pace]] = defaultdict(list)
    for pinger in group:
        buses[pinger.bus].append(pinger.pace)
    return max(
        sum(pace.held_ns + pace.collect_ns for pace in paces)
        + max(0 if pace.holds_bus else pace.ping_ns for pace in paces)
        for paces in buses.values()
    )


def _silent_ns(group: Group, speed: float) -> int:
    """From a group's turn until its sound has come back from as far as is asked for, and died away."""
    buses: defaultdict[str, int] = defaultdict(int)
    for pinger in group:
        buses[pinger.bus] += pinger.pace.held_ns
    reach = max(pinger.reach for pinger in group)
    return max(buses.values()) + round(2.0 * reach / speed * 1e9) + RING_DOWN_NS


def milliseconds(time_ns: int) -> float:
    """Of ns, rounded up to a tenth."""
    return ceil(time_ns / (MILLISECOND_NS // 10)) / 10


def wrong(key: str, what: str) -> ConfigError:
    """What is wrong with a key of [firing]."""
    return ConfigError([(("firing", key), what)])
