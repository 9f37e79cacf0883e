"""When each ranger fires: the plan that follows from [firing], the rangers' angles and what they need."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import radians
from zlib import crc32

from echogrid.drivers.make import MILLISECOND_NS
from echogrid.drivers.role import Call, Slot
from echogrid.mapping.verification import OLDEST_NS
from echogrid.runtime.config import Config, FiringConfig
from echogrid.runtime.errors import ConfigError
from echogrid.runtime.firing_groups import grouped
from echogrid.runtime.firing_times import (
    Group,
    Pinger,
    Timing,
    in_cycle,
    in_groups,
    milliseconds,
    worst_gap_ns,
    wrong,
)
from echogrid.runtime.toml_values import Problem


@dataclass(frozen=True, slots=True)
class Volley:
    """Rangers whose turns begin at one time."""

    offset_ns: int
    """In the cycle."""
    gap_ns: int
    """To the next one."""
    members: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Plan:
    """Who fires when."""

    pingers: tuple[Pinger, ...] = ()
    """Those which fire when they are told to, in the order of the file."""
    period_ns: int = 0
    """The cycle in which each of them fires once; 0 if there are none."""
    volleys: tuple[Volley, ...] = ()
    slots: Mapping[str, Slot] = field(default_factory=dict)
    calls: Mapping[str, Call] = field(default_factory=dict)


def firing_plan(config: Config, pingers: Sequence[Pinger]) -> Plan:
    """The plan for those rangers which fire when they are told to. Raises ConfigError."""
    problems = [*_strangers(config, pingers), *_deaf(config.firing, pingers)]
    if problems:
        raise ConfigError(problems)
    if not pingers:
        return Plan()
    groups = _groups(config.firing, pingers)
    calls = _calls(config.firing, groups)
    timing = in_groups(config, groups) if config.firing.mode == "groups" else in_cycle(config, groups)
    slots = _slots(config, groups, timing)
    if config.firing.verifies:
        _require_neighbours(slots)
    return Plan(tuple(pingers), timing.period_ns, _volleys(groups, timing), slots, calls)


def _require_neighbours(slots: Mapping[str, Slot]) -> None:
    """Raises ConfigError if readings of a ranger are so far apart that none would be compared."""
    for name, slot in slots.items():
        if (gap_ns := worst_gap_ns(slot)) > OLDEST_NS:
            gap = f"pings of {name!r} may be {milliseconds(gap_ns)} ms apart"
            limit = f"more than {OLDEST_NS // MILLISECOND_NS} ms are not compared"
            raise wrong("verify", f"{gap}, and {limit}: have it fire more often, or set it to false")


def _strangers(config: Config, pingers: Sequence[Pinger]) -> Iterator[Problem]:
    """Names in `groups` which fire by themselves, and rangers that are in none."""
    if not config.firing.groups:
        return
    place = "firing", "groups"
    told, grouped_names = {pinger.name for pinger in pingers}, set[str]().union(*config.firing.groups)
    for sensor in config.sensor:
        if sensor.name in grouped_names and sensor.name not in told:
            yield place, f"{sensor.name!r} fires by itself: take it out"
        if sensor.name in told and sensor.name not in grouped_names:
            yield place, f"{sensor.name!r} fires when it is told to, and is in no group: put it into one"


def _deaf(firing: FiringConfig, pingers: Sequence[Pinger]) -> Iterator[Problem]:
    """What no ranger can do that is asked of them."""
    if firing.listen_every and not any(pinger.can_listen for pinger in pingers):
        yield ("firing", "listen_every"), "no ranger here can listen without a ping: leave it out"
    if firing.general_call and not any(pinger.obeys_general_call for pinger in pingers):
        yield ("firing", "general_call"), "no ranger here obeys a general call: leave it out"


def _groups(firing: FiringConfig, pingers: Sequence[Pinger]) -> tuple[Group, ...]:
    by_name = {pinger.name: pinger for pinger in pingers}
    if firing.groups:
        return tuple(tuple(by_name[name] for name in group) for group in firing.groups)
    if firing.mode == "together":
        return (tuple(pingers),)
    found = grouped([pinger.bearing for pinger in pingers], radians(firing.separation_deg))
    return tuple(tuple(pingers[index] for index in group) for group in found)


def _calls(firing: FiringConfig, groups: Sequence[Group]) -> dict[str, Call]:
    """Who fires all on its bus, and who is fired so. Raises ConfigError if a call would fire other groups."""
    calls: dict[str, Call] = {}
    callers: dict[str, Group] = {}
    for group in groups if firing.general_call else ():
        obeying = [pinger for pinger in group if pinger.obeys_general_call]
        for pinger in obeying:
            if callers.setdefault(pinger.bus, group) is not group:
                both = "are in several groups, and one call fires them all: put them into one"
                raise wrong("general_call", f"those on bus {pinger.bus!r} that obey it {both}")
            on_bus = [other.name for other in obeying if other.bus == pinger.bus]
            if len(on_bus) > 1:
                calls[pinger.name] = Call.ALL if pinger.name == on_bus[0] else Call.CALLED
    return calls


def _volleys(groups: Sequence[Group], timing: Timing) -> tuple[Volley, ...]:
    ends = *timing.offsets_ns[1:], timing.period_ns
    return tuple(
        Volley(offset_ns, end_ns - offset_ns, tuple(pinger.name for pinger in group))
        for group, offset_ns, end_ns in zip(groups, timing.offsets_ns, ends, strict=True)
    )


def _slots(config: Config, groups: Sequence[Group], timing: Timing) -> dict[str, Slot]:
    """Each one's turns. All are late by the same in one cycle, but listen in different ones."""
    firing, slots = config.firing, dict[str, Slot]()
    listeners = 0
    for group, offset_ns in zip(groups, timing.offsets_ns, strict=True):
        for pinger in group:
            listens = firing.listen_every if pinger.can_listen else 0
            slots[pinger.name] = Slot(
                timing.period_ns,
                offset_ns,
                timing.delays_ns.get(pinger.name, (0,)),
                round(firing.jitter_ms * MILLISECOND_NS),
                listens,
                listeners % listens if listens else 0,
                crc32(config.robot.name.encode()),
            )
            listeners += 1
    return slots
