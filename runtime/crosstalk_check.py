"""How well firing patterns keep a ring of sonars from hearing each other, against the emulated acoustics.

Sixteen rangers drive through the office. What each hears of a ping is reckoned twice, with the pings of the
others in the air and without them, and with the same noise of its own: so one knows which readings are false.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from heapq import heapify, heappop, heappush
from math import cos, radians, sin

from echogrid.drivers.readings import RangeReading, classify
from echogrid.drivers.role import Slot
from echogrid.emulation import hearing
from echogrid.emulation.air import Air
from echogrid.emulation.hearing import Outing
from echogrid.emulation.offices import office, office_tour
from echogrid.emulation.transducers import TRANSDUCERS
from echogrid.mapping.placed_ping import PlacedPing
from echogrid.mapping.pose import Pose
from echogrid.mapping.verification import Verifier, heard_at
from echogrid.runtime.config import Config, FiringConfig
from echogrid.runtime.hardware_config import BusConfig, SensorConfig
from echogrid.runtime.lines import plan_of
from echogrid.runtime.loop import SECOND_NS

SONARS = 16
MODEL = "srf08"
FIRST_ADDRESS = 0x70
RING_RADIUS_M = 0.2
BLANKING_M, REACH_M = 0.04, 6.0
FALSE_M = 0.2
"""A reading is false that differs by more from what is heard without the others."""
MOST_METRES = 10.0
"""A longer tour takes its time, and tells the same."""

NAMES = tuple(f"ring_{number}" for number in range(SONARS))


@dataclass(frozen=True, slots=True)
class Pattern:
    """A way of firing."""

    firing: FiringConfig
    delays: bool = True
    """Whether the plan's delays are kept."""


PATTERNS: Mapping[str, Pattern] = {
    "all at once": Pattern(FiringConfig(mode="together")),
    "groups, as quick as sound and devices allow": Pattern(FiringConfig()),
    "groups, quicker than that": Pattern(FiringConfig(mode="eeruf"), delays=False),
    "EERUF, all from one start": Pattern(FiringConfig(mode="eeruf", groups=(NAMES,))),
    "EERUF": Pattern(FiringConfig(mode="eeruf")),
}


@dataclass(frozen=True, slots=True)
class Shares:
    """What became of the pings of a pattern."""

    cycle_ms: float
    false: float
    """Of all readings: so many say what is not there because of others' pings."""
    let_through: float
    """False ones, of the echoes that are verified."""
    kept: float
    """Verified ones, of the echoes that are true."""
    let_through_at_once: float
    """The same of those which agree with the one before, as the book has it: false ones of these,"""
    kept_at_once: float
    """and these of the true ones."""


def table(seed: int, metres: float) -> Iterator[str]:
    """Rows of Markdown: each pattern's figures."""
    way = min(metres, MOST_METRES)
    head = "cycle | false | let through | kept | by the book: let through | kept"
    yield f"| {SONARS} sonars, {way:g} m of the office | {head} |"
    yield "|---|---|---|---|---|---|---|"
    for name, pattern in PATTERNS.items():
        s = shares(pattern, seed, way)
        parts = s.false, s.let_through, s.kept, s.let_through_at_once, s.kept_at_once
        yield f"| {name} | {s.cycle_ms:.0f} ms | {' | '.join(f'{100.0 * part:.2f} %' for part in parts)} |"


def shares(pattern: Pattern, seed: int, metres: float) -> Shares:
    """Drive so far with that pattern, and judge every reading."""
    config = ring(pattern.firing)
    plan = plan_of(config)
    slots = {
        name: slot if pattern.delays else replace(slot, delays_ns=(0,)) for name, slot in plan.slots.items()
    }
    end_ns = round(_seconds(metres) * SECOND_NS)
    alone = {
        (fired_ns, ping.reading.sensor): ping
        for fired_ns, ping in _Drive(config, seed, shares_air=False).pings(slots, end_ns)
    }
    pings = [
        (ping, _is_false(ping, alone[fired_ns, ping.reading.sensor]))
        for fired_ns, ping in _Drive(config, seed, shares_air=True).pings(slots, end_ns)
    ]
    return _judged(pings, pattern.firing.agreement_m, plan.period_ns)


def ring(firing: FiringConfig) -> Config:
    """A robot with sonars all around, on one bus."""
    bearings = [360.0 * number / SONARS for number in range(SONARS)]
    sensors = (
        SensorConfig(
            name,
            RING_RADIUS_M * cos(radians(bearing)),
            RING_RADIUS_M * sin(radians(bearing)),
            bearing,
            half_angle_deg=8.0,
            min_m=BLANKING_M,
            max_m=REACH_M,
            driver=MODEL,
            bus="ring_bus",
            settings={"address": FIRST_ADDRESS + number},
        )
        for number, (name, bearing) in enumerate(zip(NAMES, bearings, strict=True))
    )
    return Config(bus=(BusConfig("ring_bus", "i2c", "ring_bus"),), sensor=tuple(sensors), firing=firing)


def _seconds(metres: float) -> float:
    """How long the tour takes for so much of its way."""
    tour = office_tour()
    return next(second for second in range(1, 1_000_000) if tour.distance(second) >= metres)


class _Drive:
    """The robot on its tour, for so long; its rangers share the air, or each has it for itself."""

    def __init__(self, config: Config, seed: int, shares_air: bool) -> None:
        self._tour = office_tour()
        outing = Outing(office(), lambda now_ns: self._tour.pose(now_ns / SECOND_NS), seed)
        shared = Air(outing)
        self._speed = shared.speed_of_sound
        self._rangers = {sensor.name: sensor.ranger() for sensor in config.sensor}
        self._surroundings = {
            name: (shared if shares_air else Air(outing)).surroundings(
                hearing.Ranger(name, (r.mount.x, r.mount.y, r.mount.yaw), TRANSDUCERS[MODEL])
            )
            for name, r in self._rangers.items()
        }

    def pings(self, slots: Mapping[str, Slot], end_ns: int) -> Iterator[tuple[int, PlacedPing]]:
        """When each ranger fired and what it heard, in the order in which they have done listening."""
        window_ns = self._flight_ns(2.0 * REACH_M)
        due = [(slot.next_turn(0).start_ns, 0, name) for name, slot in slots.items()]
        heapify(due)
        while due[0][0] <= end_ns:
            now_ns, fired_ns, name = heappop(due)
            if fired_ns:
                yield fired_ns, self._ping(name, fired_ns)
            else:
                self._surroundings[name].ping(now_ns)
                heappush(due, (now_ns + window_ns, now_ns, name))
                heappush(due, (slots[name].next_turn(now_ns).start_ns, 0, name))

    def _ping(self, name: str, fired_ns: int) -> PlacedPing:
        ranger = self._rangers[name]
        echoes = self._surroundings[name].scene(fired_ns)
        first = next((echo.distance for echo in echoes if echo.margin >= 0.0), REACH_M)
        outcome, distance = classify(first, ranger.nearest, ranger.farthest)
        stamp_ns = fired_ns + self._flight_ns(min(first, REACH_M))
        robot = Pose(*self._tour.pose(stamp_ns / SECOND_NS))
        return PlacedPing(
            RangeReading(stamp_ns, 0, name, outcome, distance), ranger, robot.compose(ranger.mount)
        )

    def _flight_ns(self, way: float) -> int:
        return round(way / self._speed * SECOND_NS)


def _judged(pings: list[tuple[PlacedPing, bool]], agreement: float, cycle_ns: int) -> Shares:
    """Pings, and whether they are false."""
    verifier = Verifier(agreement)
    verified: set[int] = set()
    at_once: set[int] = set()
    for ping, _ in sorted(pings, key=lambda each: each[0].reading.stamp_ns):
        passed = {id(each) for each in verifier.take(ping).verified}
        verified |= passed
        at_once |= passed & {id(ping)}
    echoes = [(id(ping), false) for ping, false in pings if heard_at(ping) is not None]
    share_false = sum(false for _, false in pings) / len(pings)
    return Shares(cycle_ns * 1e-6, share_false, *_passed(echoes, verified), *_passed(echoes, at_once))


def _passed(echoes: list[tuple[int, bool]], believed: set[int]) -> tuple[float, float]:
    """The part of the believed ones that is false, and of the true ones that is believed."""
    passed = [false for each, false in echoes if each in believed]
    true = [each in believed for each, false in echoes if not false]
    return sum(passed) / max(len(passed), 1), sum(true) / max(len(true), 1)


def _is_false(ping: PlacedPing, alone: PlacedPing) -> bool:
    """Whether a ranger hears what it would not hear alone."""
    heard, echo = heard_at(ping), heard_at(alone)
    return heard is not None and (echo is None or abs(heard - echo) > FALSE_M)
