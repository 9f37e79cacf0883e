from dataclasses import replace
from itertools import combinations, pairwise
from math import radians
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from echogrid.drivers.pace import Pace
from echogrid.drivers.role import Call, Slot
from echogrid.runtime import lines, robot_file
from echogrid.runtime.config import Config, FiringConfig
from echogrid.runtime.emulated import DEFAULT_ROBOT
from echogrid.runtime.errors import ConfigError
from echogrid.runtime.firing import Plan, firing_plan
from echogrid.runtime.firing_groups import angle_between
from echogrid.runtime.firing_times import RING_DOWN_NS, SLACK_NS, Pinger, worst_gap_ns
from echogrid.runtime.hardware_config import SensorConfig

MS = 1_000_000
SPEED = 343.214
PACE = Pace(ping_ns=20 * MS, rest_ns=58 * MS, fire_ns=300_000, collect_ns=700_000)
RINGS = [f"ring_{angle}" for angle in range(0, 360, 45)]


def pingers(count: int, pace: Pace = PACE, **others: Any) -> list[Pinger]:
    return [Pinger(f"r{n}", radians(360.0 * n / count), 3.0, "bus", pace, **others) for n in range(count)]


def configured(firing: FiringConfig, ring: list[Pinger], *others: str) -> Config:
    names = [*(pinger.name for pinger in ring), *others]
    return Config(sensor=tuple(SensorConfig(name, 0, 0, 0, 10, 0.05, 3.0) for name in names), firing=firing)


def plan(firing: FiringConfig, ring: list[Pinger], *others: str) -> Plan:
    return firing_plan(configured(firing, ring, *others), ring)


def refused(firing: FiringConfig, ring: list[Pinger], *others: str) -> str:
    with pytest.raises(ConfigError) as told:
        plan(firing, ring, *others)
    return str(told.value)


def groups(made: Plan) -> list[tuple[str, ...]]:
    return [volley.members for volley in made.volleys]


def built_in(firing: FiringConfig | None = None) -> Config:
    config = robot_file.load(DEFAULT_ROBOT)
    return config if firing is None else replace(config, firing=firing)


# Groups


def test_explicit_groups_and_gap_are_taken_as_they_are() -> None:
    slots = lines.plan_of(built_in()).slots
    assert slots["ring_0"] == slots["ring_180"]
    assert (slots["ring_0"].period_ns, slots["ring_0"].offset_ns) == (280 * MS, 0)
    assert (slots["ring_45"].offset_ns, slots["ring_135"].offset_ns) == (140 * MS, 210 * MS)


def test_rangers_that_fire_by_themselves_are_left_out() -> None:
    made = lines.plan_of(built_in(FiringConfig()))
    assert sorted(made.slots) == sorted(RINGS)
    assert groups(made) == [
        ("ring_0", "ring_90", "ring_180", "ring_270"),
        ("ring_45", "ring_135", "ring_225", "ring_315"),
    ]


@settings(max_examples=30)
@given(st.integers(1, 16), st.sampled_from([45.0, 90.0, 180.0]), st.sampled_from(["groups", "eeruf"]))
def test_two_of_a_group_are_as_far_apart_as_is_asked(count: int, separation: float, mode: Any) -> None:
    ring = pingers(count)
    made = plan(FiringConfig(mode=mode, separation_deg=separation), ring)
    bearings = {pinger.name: pinger.bearing for pinger in ring}
    for group in groups(made):
        for one, other in combinations(group, 2):
            assert angle_between(bearings[one], bearings[other]) >= radians(separation) - 1e-6


def test_a_group_has_the_time_of_its_sound_and_of_the_ring_down() -> None:
    made = plan(FiringConfig(), pingers(16))
    flight_ns = round(2 * 3.0 / SPEED * 1e9)
    for volley in made.volleys:
        assert volley.gap_ns == pytest.approx(4 * PACE.fire_ns + flight_ns + RING_DOWN_NS, abs=5000)


def test_a_group_of_slow_rangers_has_the_time_of_their_pings_and_of_the_bus() -> None:
    slow = replace(PACE, ping_ns=66 * MS)
    made = plan(FiringConfig(), pingers(16, slow))
    assert {volley.gap_ns for volley in made.volleys} == {66 * MS + 4 * 1 * MS}


def test_one_that_answers_the_command_itself_is_waited_for_before_the_next_on_its_bus() -> None:
    slow = Pace(120 * MS, 20 * MS, 10 * MS, 0, holds_bus=True)
    made = plan(FiringConfig(), pingers(4, slow))
    assert 4 * 130 * MS <= made.period_ns <= 4 * 140 * MS


def test_few_groups_get_more_time_so_that_all_may_fire_again() -> None:
    assert plan(FiringConfig(), pingers(4)).period_ns == 58 * MS + SLACK_NS


def test_a_gap_that_is_too_short_is_refused_with_the_least_that_would_do() -> None:
    assert "gap_ms: it takes 61.0 ms" in refused(FiringConfig(gap_ms=60.9), pingers(4))
    assert plan(FiringConfig(gap_ms=61.0), pingers(4)).period_ns == 61 * MS
    assert "gap_ms: it takes 24.0 ms" in refused(FiringConfig(gap_ms=23.0), pingers(16))
    assert plan(FiringConfig(gap_ms=24.0), pingers(16)).period_ns == 96 * MS


def test_names_in_groups_must_be_of_those_and_all_of_those_that_wait_to_be_told() -> None:
    ring = pingers(3)
    told = refused(FiringConfig(groups=(("r0", "stream"), ("r1",))), ring, "stream")
    assert "'stream' fires by itself: take it out" in told
    assert "'r2' fires when it is told to, and is in no group" in told


def test_nobody_to_be_told_needs_no_plan() -> None:
    assert plan(FiringConfig(), [], "stream") == Plan()


def test_of_i2c_the_slowest_is_reckoned_with_that_is_usual_whatever_the_file_says() -> None:
    config = built_in(FiringConfig(mode="eeruf"))
    quick = replace(
        config, bus=tuple(replace(bus, bit_rate=400_000) for bus in config.bus if bus.kind == "i2c")
    )
    others = tuple(bus for bus in config.bus if bus.kind != "i2c")
    assert lines.plan_of(replace(quick, bus=(*quick.bus, *others))) == lines.plan_of(config)


# A cycle for all


@pytest.mark.parametrize("mode", ["eeruf", "together"])
def test_all_fire_once_in_a_tenth_of_a_second(mode: Any) -> None:
    made = plan(FiringConfig(mode=mode), pingers(16))
    assert made.period_ns == 100 * MS
    assert {slot.period_ns for slot in made.slots.values()} == {100 * MS}


def test_together_they_all_fire_at_once() -> None:
    made = plan(FiringConfig(mode="together"), pingers(5))
    assert set(made.slots.values()) == {Slot(100 * MS, 0, seed=made.slots["r0"].seed)}


@settings(max_examples=30)
@given(st.integers(1, 12), st.integers(30, 150), st.integers(0, 10))
def test_each_has_answered_and_rested_before_its_next_turn(count: int, rest_ms: int, jitter_ms: int) -> None:
    pace = replace(PACE, rest_ns=rest_ms * MS)
    made = plan(FiringConfig(mode="eeruf", jitter_ms=jitter_ms), pingers(count, pace))
    for slot in made.slots.values():
        turn = slot.next_turn(0)
        for _ in range(7):
            following = slot.next_turn(turn.start_ns)
            assert following.start_ns - turn.start_ns >= pace.period_ns + SLACK_NS
            turn = following


def test_a_cycle_that_is_too_short_is_refused_with_the_least_that_would_do() -> None:
    told = refused(FiringConfig(mode="eeruf", cycle_ms=60.0), pingers(8))
    least = float(told.split("it takes ")[1].split(" ms")[0])
    assert 61.0 < least < 80.0
    assert plan(FiringConfig(mode="eeruf", cycle_ms=least), pingers(8)).period_ns == round(least * MS)


def test_slow_rangers_have_a_longer_cycle_by_themselves() -> None:
    made = plan(FiringConfig(mode="together"), pingers(4, replace(PACE, rest_ns=148 * MS)))
    assert made.period_ns == 148 * MS + SLACK_NS


def test_a_bus_must_carry_all_within_the_cycle() -> None:
    made = plan(FiringConfig(mode="together"), pingers(16, replace(PACE, fire_ns=5 * MS, collect_ns=5 * MS)))
    assert made.period_ns >= 160 * MS


def test_of_those_that_hold_their_bus_one_fires_after_the_other() -> None:
    held = Pace(120 * MS, 20 * MS, 10 * MS, 0, holds_bus=True)
    made = plan(FiringConfig(mode="eeruf"), pingers(4, held))
    assert 4 * 130 * MS < made.period_ns < 5 * 130 * MS
    for number in range(3):
        starts = sorted(slot.planned_ns(number) for slot in made.slots.values())
        assert all(later - one >= 130 * MS for one, later in pairwise(starts))


def test_a_cycle_in_which_a_bus_is_too_busy_is_refused_with_one_that_would_do() -> None:
    busy = replace(PACE, collect_ns=8 * MS)
    told = refused(FiringConfig(mode="eeruf", cycle_ms=100.0), pingers(8, busy))
    assert "until every turn finds bus 'bus' idle" in told
    assert "use more buses" in told
    least = float(told.split("it takes ")[1].split(" ms")[0])
    assert plan(FiringConfig(mode="eeruf", cycle_ms=least), pingers(8, busy)).period_ns == round(least * MS)
    assert plan(FiringConfig(mode="eeruf"), pingers(8, busy)).period_ns == round(least * MS)


def test_on_more_buses_the_same_rangers_have_a_shorter_cycle() -> None:
    ring = pingers(8, replace(PACE, collect_ns=8 * MS))
    spread = [replace(pinger, bus=f"bus {number % 2}") for number, pinger in enumerate(ring)]
    firing = FiringConfig(mode="eeruf")
    assert plan(firing, spread).period_ns < plan(firing, ring).period_ns


def test_more_than_there_are_delays_for_are_refused() -> None:
    ring = [replace(pinger, bus=pinger.name) for pinger in pingers(70)]
    assert "no delays tell so many rangers apart" in refused(FiringConfig(mode="eeruf"), ring)


def test_a_bus_that_no_cycle_is_long_enough_for_is_named() -> None:
    endless = Pace(4_000 * MS, 20 * MS, 10 * MS, 0, holds_bus=True)
    told = refused(FiringConfig(mode="eeruf"), pingers(4, endless))
    assert "mode: no cycle is long enough until every turn finds bus 'bus' idle" in told


def test_the_longest_gap_counts_delays_chance_and_turns_without_a_ping() -> None:
    slot = Slot(100 * MS, 0, (0, 5 * MS, 2 * MS))
    assert worst_gap_ns(slot) == 105 * MS
    assert worst_gap_ns(Slot(100 * MS, 0, (0, 5 * MS, 2 * MS), jitter_ns=7 * MS)) == 112 * MS
    assert worst_gap_ns(Slot(100 * MS, 0, (0, 5 * MS, 2 * MS), listens_every=4)) == 203 * MS


def test_pings_too_far_apart_to_be_compared_are_refused() -> None:
    told = refused(FiringConfig(verify=True, gap_ms=1600.0), pingers(8))
    assert "verify: pings of 'r0' may be 3200.0 ms apart, and more than 3000 ms are not compared" in told
    plan(FiringConfig(verify=True, gap_ms=1500.0), pingers(8))


def test_chance_and_turns_that_only_listen_count_for_how_far_apart_they_are() -> None:
    late = FiringConfig(verify=True, gap_ms=1400.0, jitter_ms=100.0)
    plan(late, pingers(8))
    plan(replace(late, listen_every=4, gap_ms=650.0), pingers(8, can_listen=True))
    told = refused(replace(late, listen_every=4), pingers(8, can_listen=True))
    assert "verify: pings of 'r0' may be 5900.0 ms apart" in told


# Chance, and listening


def test_in_one_cycle_all_are_late_by_the_same_and_robots_differ() -> None:
    firing = FiringConfig(mode="together", jitter_ms=20.0)
    slots = list(plan(firing, pingers(4)).slots.values())
    starts = {slot.next_turn(5 * 100 * MS).start_ns for slot in slots}
    assert len(starts) == 1
    config = configured(firing, pingers(4))
    other = replace(config, robot=replace(config.robot, name="other"))
    foreign = firing_plan(other, pingers(4)).slots["r0"]
    assert foreign.next_turn(5 * 100 * MS).start_ns not in starts


def test_those_that_can_listen_do_so_in_turn() -> None:
    ring = [replace(pinger, can_listen=pinger.name != "r3") for pinger in pingers(8)]
    slots = plan(FiringConfig(mode="together", listen_every=4), ring).slots
    assert slots["r3"].listens_every == 0
    for number in range(8):
        listening = {name for name, slot in slots.items() if slot.next_turn(number * 100 * MS).listens}
        assert len(listening) in (1, 2)


def test_listening_is_refused_where_nobody_can() -> None:
    assert "listen_every: no ranger here can listen" in refused(FiringConfig(listen_every=4), pingers(4))


# The general call


def test_the_first_on_a_bus_fires_all_that_obey_a_general_call() -> None:
    ring = pingers(4, obeys_general_call=True)
    ring[3] = replace(ring[3], obeys_general_call=False)
    ring.append(replace(ring[0], name="alone", bus="another"))
    made = plan(FiringConfig(mode="together", general_call=True), ring)
    assert made.calls == {"r0": Call.ALL, "r1": Call.CALLED, "r2": Call.CALLED}
    assert plan(FiringConfig(mode="together"), ring).calls == {}


def test_a_general_call_is_refused_where_nobody_obeys_it() -> None:
    told = refused(FiringConfig(mode="together", general_call=True), pingers(4))
    assert "general_call: no ranger here obeys a general call" in told


def test_a_call_that_would_fire_other_groups_is_refused() -> None:
    told = refused(FiringConfig(general_call=True), pingers(8, obeys_general_call=True))
    assert "general_call: those on bus 'bus' that obey it are in several groups" in told


def test_the_devices_are_told_who_fires_them() -> None:
    config = built_in(FiringConfig(mode="together", general_call=True))
    calls = lines.plan_of(config).calls
    assert [name for name, call in calls.items() if call is Call.ALL] == ["ring_0"]
    assert sorted(calls) == sorted(RINGS)
    lines.lines(config)
