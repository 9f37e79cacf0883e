from dataclasses import dataclass
from math import tau
from random import Random

from hypothesis import given
from hypothesis.strategies import booleans, floats, integers, lists, sampled_from, tuples
from pytest import approx, mark

from echogrid.drivers.counter import RESTART_NS, CountedWheel, Scale, difference
from echogrid.drivers.readings import WheelReading
from echogrid.drivers.role import WheelRole

MS = 1_000_000
ROLE = WheelRole("left", fastest=50.0)
MODULI = sampled_from([1 << 16, 1 << 24, 1 << 32, 64_000])
PER_TURN = 3600
MOST = int(ROLE.fastest / tau * PER_TURN * 0.010)
"""Counts in 10 ms."""


def signed(total: int, modulus: int) -> int:
    """What a counter shows which truly went so far."""
    return (total + modulus // 2) % modulus - modulus // 2


def counts(reading: WheelReading, gear: float = 1.0) -> int:
    return round(reading.angle / tau * gear * PER_TURN)


def wheel(modulus: int = 1 << 32, role: WheelRole = ROLE) -> CountedWheel:
    return CountedWheel(role, Scale(modulus, PER_TURN))


def read(counted: CountedWheel, *told: tuple[int, int]) -> list[WheelReading]:
    """The readings of counts by their times (ms)."""
    readings: list[WheelReading] = []
    for at_ms, count in told:
        counted.heard(at_ms * MS)
        readings += counted.read(at_ms * MS, count, b"")
    return readings


@given(integers(), integers(), integers(1, 1 << 40).map(lambda half: 2 * half))
def test_a_difference_is_the_shortest_way_round(new: int, old: int, modulus: int) -> None:
    way = difference(new, old, modulus)
    assert -modulus // 2 <= way < modulus // 2
    assert (old + way - new) % modulus == 0


@mark.parametrize(
    ("new", "old", "way"), [(-32768, 32767, 1), (32767, -32768, -1), (5, -5, 10), (-32768, 0, -32768)]
)
def test_sixteen_bits_wrap_in_both_directions(new: int, old: int, way: int) -> None:
    assert difference(new, old, 1 << 16) == way


@given(
    MODULI,
    sampled_from([-1, 0, 1]),
    integers(-100, 100),
    lists(integers(-MOST, MOST), min_size=1),
    floats(1, 9),
)
def test_wraps_in_both_directions_are_those_of_whole_numbers_without_end(
    modulus: int, edge: int, offset: int, steps: list[int], gear: float
) -> None:
    role = WheelRole("left", gear=gear, fastest=ROLE.fastest)
    counted, total = wheel(modulus, role), edge * (modulus // 2) + offset
    (first,) = read(counted, (0, signed(total, modulus)))
    start = total
    for n, step in enumerate(steps, 1):
        total += step
        (reading,) = read(counted, (n * 10, signed(total, modulus)))
        assert counts(reading, gear) - counts(first, gear) == total - start
        assert not reading.discontinuity


@mark.parametrize("direction", [1, -1])
def test_many_times_round_loses_nothing(direction: int) -> None:
    counted, total = wheel(1 << 16), 0
    for n in range(5000):
        (reading,) = read(counted, (n * 10, signed(total, 1 << 16)))
        assert (counts(reading), reading.discontinuity) == (total, False)
        total += direction * MOST


def test_a_pause_in_which_it_could_have_gone_half_round_is_a_discontinuity() -> None:
    half_round_ms = round(32_768 / (ROLE.fastest / tau * PER_TURN) * 1000) - 20
    for pause_ms, jumped in ((half_round_ms - 2, False), (half_round_ms + 2, True)):
        counted = wheel(1 << 16)
        readings = read(counted, (0, 20_000))
        for at_ms in range(0, pause_ms, 100):
            counted.heard(at_ms * MS)
        readings += read(counted, (pause_ms, 20_100))
        assert [reading.discontinuity for reading in readings] == [False, jumped]
        assert counts(readings[-1]) == 20_000 + 100 * (not jumped)


def test_after_a_silence_a_count_within_reach_of_zero_may_be_a_restart() -> None:
    readings = read(wheel(), (0, 40_000), (400, 300), (410, 310))
    assert [reading.discontinuity for reading in readings] == [False, True, False]
    assert [counts(reading) for reading in readings] == [40_000, 40_000, 40_010]


def test_after_a_silence_a_count_out_of_reach_of_zero_is_motion() -> None:
    readings = read(wheel(), (0, 40_000), (400, 42_000))
    assert [(counts(reading), reading.discontinuity) for reading in readings] == [
        (40_000, False),
        (42_000, False),
    ]


def test_while_other_frames_come_it_has_not_restarted() -> None:
    counted = wheel()
    readings = read(counted, (0, 10))
    for at_ms in range(100, 1000, 100):
        counted.heard(at_ms * MS)
    readings += read(counted, (1000, 400))
    assert [(counts(reading), reading.discontinuity) for reading in readings] == [(10, False), (400, False)]


def test_after_a_lost_port_it_may_have_restarted() -> None:
    counted = wheel()
    readings = read(counted, (0, 500))
    counted.lost()
    assert [reading.discontinuity for reading in readings + read(counted, (50, 20))] == [False, True]


def test_a_restart_that_is_known_is_no_motion() -> None:
    counted = wheel()
    readings = read(counted, (0, 90))
    counted.restarted()
    readings += read(counted, (10, 0), (20, 5))
    assert [(counts(reading), reading.discontinuity) for reading in readings] == [
        (90, False),
        (90, True),
        (95, False),
    ]


def test_one_count_far_off_is_dropped_even_in_a_narrow_counter() -> None:
    counted = wheel(1 << 16)
    readings = read(counted, (0, 0), (10, 30_000), (20, -30_000), (30, 50))
    assert [(counts(reading), reading.discontinuity) for reading in readings] == [(0, False), (50, False)]
    assert counted.counts["doubtful jumps"] == 2


def test_a_jump_that_a_second_count_confirms_is_no_motion() -> None:
    readings = read(wheel(), (0, 0), (10, 1_000_000), (20, 1_000_010), (30, 1_000_020))
    assert [(counts(reading), reading.discontinuity) for reading in readings] == [
        (0, False),
        (0, True),
        (10, False),
    ]


def test_older_counts_are_dropped_and_equal_ones_are_no_motion() -> None:
    counted = wheel()
    readings = read(counted, (10, 100), (10, 100), (5, 50), (20, 110))
    assert [counts(reading) for reading in readings] == [100, 100, 110]
    assert counted.counts["counts out of order"] == 1


def test_the_rate_is_the_one_told_or_else_the_mean_since_the_last_count() -> None:
    counted = wheel()
    (told,) = counted.read(0, 0, b"", 2.0)
    (mean,) = counted.read(10 * MS, 36, b"")
    (same,) = counted.read(10 * MS, 36, b"")
    (beyond,) = counted.read(20 * MS, 36, b"", 1e9)
    assert [reading.rate for reading in (told, mean, same, beyond)] == approx([2 * tau, tau, tau, 0.0])


@dataclass
class Truth:
    """A wheel that turns, and a controller that counts it from its latest start."""

    modulus: int
    total: int = 0
    zero: int = 0

    def count(self) -> int:
        return signed(self.total - self.zero, self.modulus)


EVENTS = tuples(
    sampled_from(["frame"] * 6 + ["twice", "lost", "silence", "restart", "port", "garbled"]),
    floats(-1, 1),
    integers(0, 4),
    booleans(),
)


@given(MODULI, integers(-(1 << 33), 1 << 33), lists(EVENTS, max_size=80), integers(0, 99))
def test_every_step_is_the_right_distance_or_a_flagged_discontinuity(
    modulus: int, start: int, events: list[tuple[str, float, int, bool]], seed: int
) -> None:
    """Whatever is lost, doubled or restarted. A restart takes its time; a garbled count is far off."""
    counted, truth, random = wheel(modulus), Truth(modulus, zero=start), Random(seed)
    now_ms, true_ms, last = 0, -1000, None
    for kind, speed, pauses, rolls in events:
        pause_ms = RESTART_NS // MS + 1 + 100 * pauses if kind in ("restart", "silence") else 10
        now_ms += pause_ms
        truth.total += int(speed * MOST * pause_ms / 10)
        if kind == "restart":
            rolled = int(speed * MOST) if rolls else 0
            truth.zero = truth.total - rolled
        if kind == "port":
            counted.lost()
        if kind == "lost":
            continue
        told = truth.count()
        if kind == "garbled" and now_ms - true_ms < 50:
            told = signed(told + modulus // 4 + random.randrange(modulus // 8), modulus)
            true_ms = -1000
        else:
            true_ms = now_ms
        for _ in range(2 if kind == "twice" else 1):
            for reading in read(counted, (now_ms, told)):
                if last is not None:
                    moved = counts(reading) - counts(last[0])
                    assert moved == (0 if reading.discontinuity else truth.total - last[1])
                last = reading, truth.total
