"""When the groups of a firing plan have their turns, and how long a cycle is: what sound and devices need."""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from echogrid.drivers.make import MILLISECOND_NS
from echogrid.drivers.pace import Pace
from echogrid.drivers.role import Slot
from echogrid.drivers.sound import speed_of_sound
from echogrid.runtime.config import Config
from echogrid.runtime.errors import ConfigError
from echogrid.runtime.firing_patterns import Cycle, Seat, delays

RING_DOWN_NS = 8 * MILLISECOND_NS
"""After the last echo that is asked for: 5 to 10 ms until the sound has died away."""
SLACK_NS = 3 * MILLISECOND_NS
"""How late a turn may be without the ranger missing the next."""
CYCLE_NS = 100 * MILLISECOND_NS
"""In which all fire once, where they can, unless they fire in groups."""
LONGEST_NS = 10_000 * MILLISECOND_NS
"""Of a cycle."""
_TENTH_NS = MILLISECOND_NS // 10
_GROWTH = 20
"""A cycle that was too short is tried again with this part of it more."""
_ANSWERED = "until all have answered, and may fire again"
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
    jitter_ns = _jitter_ns(config)
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
            raise wrong("gap_ms", f"it takes {milliseconds(least_ns)} ms {_ANSWERED}: give as much at least")
    offsets = [sum(gaps[:number]) for number in range(len(groups))]
    return Timing(sum(gaps) + jitter_ns, tuple(offsets))


def in_cycle(config: Config, groups: Sequence[Group]) -> Timing:
    """All in one cycle, which the groups share evenly: as long as is asked for, or as it takes."""
    asked_ms = config.firing.cycle_ms
    asked_ns = CYCLE_NS if asked_ms is None else round(asked_ms * MILLISECOND_NS)
    at_once_ns = max(map(_busy_ns, groups)) + SLACK_NS if config.firing.mode == "together" else 0
    least_ns = _tenths(max(_cycle_ns(groups), at_once_ns) + _jitter_ns(config))
    period_ns, why = (least_ns, _ANSWERED) if least_ns > asked_ns else (asked_ns, "")
    while isinstance(found := _shared(config, groups, period_ns), str):
        period_ns, why = _tenths(period_ns + period_ns // _GROWTH), why or found
        if period_ns > LONGEST_NS:
            raise wrong("mode", f'no cycle is long enough {found}: use more buses, or "groups"')
    if why and asked_ms is not None:
        mend = "give as much" if why is _ANSWERED else "give that, use more buses, or leave it out"
        raise wrong("cycle_ms", f"it takes {milliseconds(period_ns)} ms {why}: {mend}")
    return found


def _shared(config: Config, groups: Sequence[Group], period_ns: int) -> Timing | str:
    """A cycle of that length, with the delays that it takes to tell the rangers apart; or what it is too
    short for. Raises ConfigError if there are no such delays."""
    offsets = tuple(number * period_ns // len(groups) for number in range(len(groups)))
    if config.firing.mode == "together":
        return Timing(period_ns, offsets)
    pingers = [pinger for group in groups for pinger in group]
    places = [offset_ns for offset_ns, group in zip(offsets, groups, strict=True) for _ in group]
    seats = [Seat(at_ns, each.bus, each.pace.busy) for at_ns, each in zip(places, pingers, strict=True)]
    speed = speed_of_sound(config.robot.air_temperature_c)
    step_ns = round(_SPREAD * config.firing.agreement_m / speed * 1e9)
    cycle = Cycle(period_ns, step_ns, _jitter_ns(config))
    found = delays(tuple(seats), cycle)
    if len(found) < len(seats):
        if len(delays(tuple(replace(seat, busy=()) for seat in seats), cycle)) < len(seats):
            raise wrong("mode", 'no delays tell so many rangers apart: use "groups"')
        return f"until every turn finds bus {pingers[len(found)].bus!r} idle, beside the others' answers"
    for pinger, own in zip(pingers, found, strict=True):
        if pinger.pace.period_ns + SLACK_NS + max(own) - min(own) + cycle.jitter_ns > period_ns:
            return _ANSWERED
    return Timing(period_ns, offsets, {each.name: own for each, own in zip(pingers, found, strict=True)})


def _cycle_ns(groups: Sequence[Group]) -> int:
    """The shortest cycle in which every ranger is ready again, and every bus has carried all."""
    buses: defaultdict[str, int] = defaultdict(int)
    for pinger in (pinger for group in groups for pinger in group):
        buses[pinger.bus] += pinger.pace.carried_ns
    ready_ns = max(pinger.pace.period_ns for group in groups for pinger in group)
    return max(ready_ns, *buses.values()) + SLACK_NS


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


def _jitter_ns(config: Config) -> int:
    return round(config.firing.jitter_ms * MILLISECOND_NS)


def _tenths(time_ns: int) -> int:
    """ns, rounded up to a tenth of a millisecond."""
    return -(-time_ns // _TENTH_NS) * _TENTH_NS


def milliseconds(time_ns: int) -> float:
    """Of ns, rounded up to a tenth."""
    return _tenths(time_ns) // _TENTH_NS / 10


def wrong(key: str, what: str) -> ConfigError:
    """What is wrong with a key of [firing]."""
    return ConfigError([(("firing", key), what)])


def worst_gap_ns(slot: Slot) -> int:
    """The longest time between two pings of a ranger."""
    apart = 2 if slot.listens_every else 1
    rotation = range(len(slot.delays_ns))
    gaps_ns = (slot.planned_ns(number + apart) - slot.planned_ns(number) for number in rotation)
    return max(gaps_ns) + slot.jitter_ns
