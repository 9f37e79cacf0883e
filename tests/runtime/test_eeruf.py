"""EERUF by numbers alone: rings of sonars in rooms of which nothing is known but how long the ways are."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from random import Random

import pytest

from echogrid.drivers.readings import Outcome, RangeReading
from echogrid.drivers.role import Slot
from echogrid.mapping.placed_ping import PlacedPing
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.verification import Verifier
from echogrid.runtime.config import FiringConfig
from echogrid.runtime.crosstalk_check import SONARS, ring
from echogrid.runtime.lines import plan_of

SPEED = 343.0
REACH = 6.0
NOISE = 0.01
CYCLES = 50
ROOMS = 30
Source = tuple[Slot, float]
"""Somebody who pings, and how long (m) the way of the sound is."""


@dataclass
class Tally:
    """Counts of readings."""

    readings: int = 0
    false: int = 0
    false_verified: int = 0
    true_verified: int = 0

    @property
    def false_part(self) -> float:
        return self.false / self.readings

    @property
    def passed(self) -> float:
        """Of the false ones."""
        return self.false_verified / self.false

    @property
    def let_through(self) -> float:
        """Of the verified ones."""
        return self.false_verified / max(self.false_verified + self.true_verified, 1)

    @property
    def kept(self) -> float:
        """Of the true ones."""
        return self.true_verified / (self.readings - self.false)


@dataclass
class Listener:
    """A sonar that stands before something, and the ways on which it hears others."""

    slot: Slot
    true: float
    sources: list[Source] = field(default_factory=list)

    def heard(self, number: int) -> float:
        """The nearest of the echo and of what seems to be one: r = (c/2) (L/c + t_tx - t_rx)."""
        own_ns = fired_ns(self.slot, number)
        apparent = (
            0.5 * (way + SPEED * 1e-9 * (fired_ns(other, number + shift) - own_ns))
            for other, way in self.sources
            for shift in (-1, 0, 1)
        )
        return min([self.true, *(distance for distance in apparent if 0.0 < distance < REACH)])

    def listen(self, tally: Tally, random: Random) -> None:
        """So many cycles, and what a verifier makes of them."""
        verifier, false, verified = Verifier(), dict[int, bool](), set[int]()
        ranger = Ranger("r", Pose(), 0.2, 0.0, REACH)
        for number in range(10, 10 + CYCLES):
            distance = self.heard(number)
            measured = max(distance + random.gauss(0, NOISE), 0.0)
            stamp_ns = fired_ns(self.slot, number)
            false[stamp_ns] = abs(distance - self.true) > 0.2
            reading = RangeReading(stamp_ns, 0, "r", Outcome.ECHO, measured)
            passed = verifier.take(PlacedPing(reading, ranger, Pose())).verified
            verified |= {each.reading.stamp_ns for each in passed}
        tally.readings += CYCLES
        tally.false += sum(false.values())
        tally.false_verified += sum(false[stamp_ns] for stamp_ns in verified)
        tally.true_verified += sum(not false[stamp_ns] for stamp_ns in verified)


def fired_ns(slot: Slot, number: int) -> int:
    """When its turn of that number really begins."""
    return slot.next_turn(slot.offset_ns + number * slot.period_ns - 1).start_ns


def slots_of(firing: FiringConfig, robot: str = "ours", delays: bool = True) -> list[Slot]:
    config = ring(firing)
    slots = plan_of(replace(config, robot=replace(config.robot, name=robot))).slots.values()
    return [slot if delays else replace(slot, delays_ns=(0,)) for slot in slots]


def in_rooms(slots: Sequence[Slot], seed: int, rooms: int = ROOMS) -> Tally:
    """In each room a sonar hears a few of the others, on ways of 1 to 12 m."""
    random, tally = Random(seed), Tally()
    for _ in range(rooms):
        for slot in slots:
            listener = Listener(slot, random.uniform(0.5, 5.5))
            others = [other for other in slots if other is not slot and random.random() < 2.0 / SONARS]
            listener.sources = [(other, random.uniform(1.0, 12.0)) for other in others]
            listener.listen(tally, random)
    return tally


def test_with_changing_delays_less_than_a_hundredth_is_false_and_nine_tenths_are_kept() -> None:
    tally = in_rooms(slots_of(FiringConfig(mode="eeruf")), 0, 3 * ROOMS)
    assert tally.false_part > 0.1
    assert tally.let_through < 0.01
    assert tally.kept > 0.9


@pytest.mark.parametrize("seed", range(3))
def test_without_them_the_same_turns_let_all_through(seed: int) -> None:
    tally = in_rooms(slots_of(FiringConfig(mode="eeruf"), delays=False), seed)
    assert tally.false_part > 0.1
    assert tally.passed > 0.99


@pytest.mark.parametrize("seed", range(3))
def test_all_at_once_comparing_does_not_help_either(seed: int) -> None:
    tally = in_rooms(slots_of(FiringConfig(mode="together")), seed)
    assert tally.false_part > 0.1
    assert tally.passed > 0.99


@pytest.mark.parametrize("way", [0.5, 3.0, 7.0, 12.0])
def test_whoever_is_heard_alone_is_never_believed(way: float) -> None:
    tally = Tally()
    slots = slots_of(FiringConfig(mode="eeruf"))
    for slot in slots:
        for other in slots:
            if other is not slot:
                Listener(slot, REACH - 0.01, [(other, way)]).listen(tally, Random(1))
    assert tally.false_part > 0.05
    assert tally.false_verified == 0


@pytest.mark.parametrize(("jitter_ms", "least", "most"), [(0.0, 1.0, 1.0), (20.0, 0.0, 0.2)])
def test_chance_tells_a_foreign_robot_that_fires_as_often_from_an_echo(
    jitter_ms: float, least: float, most: float
) -> None:
    firing, tally = FiringConfig(mode="together", jitter_ms=jitter_ms), Tally()
    for slot, other in zip(slots_of(firing), slots_of(firing, "theirs"), strict=True):
        Listener(slot, 5.0, [(other, 4.0)]).listen(tally, Random(1))
    assert tally.false_part > 0.5
    assert least <= tally.passed <= most
