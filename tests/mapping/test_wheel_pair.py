import pytest
from hypothesis import given
from hypothesis import strategies as st
from pytest import approx

from echogrid.drivers.readings import WheelReading
from echogrid.mapping.kinematics import Tricycle
from echogrid.mapping.wheel_pair import WheelAngles, WheelPair

MS = 1_000_000

pauses = st.lists(st.integers(1, 200), min_size=1, max_size=30)


def wheel(name: str, stamp_ms: int, angle: float) -> WheelReading:
    return WheelReading(stamp_ms * MS, 0, name, angle, 0.0)


def left(stamp_ms: int) -> WheelReading:
    return wheel("left", stamp_ms, stamp_ms * 1.0)


def right(stamp_ms: int) -> WheelReading:
    return wheel("right", stamp_ms, stamp_ms * -2.0)


def stamps(steps: list[int], start: int = 0) -> list[int]:
    return [start + sum(steps[: n + 1]) for n in range(len(steps))]


def feed(pair: WheelPair, readings: list[WheelReading]) -> list[WheelAngles]:
    pairs: list[WheelAngles] = []
    for reading in readings:
        pairs += pair.take(reading)
    return pairs


@given(pauses, pauses)
def test_both_wheels_at_steady_rates_are_read_at_the_left_one_s_stamps(
    left_steps: list[int], right_steps: list[int]
) -> None:
    lefts, rights = stamps(left_steps), stamps(right_steps)
    readings = sorted([*map(left, lefts), *map(right, rights)], key=lambda each: each.stamp_ns)
    pair = WheelPair()
    pairs = feed(pair, readings)
    paired = [at for at in lefts if rights[0] <= at <= rights[-1]]
    assert [angles.stamp_ns for angles in pairs] == [at * MS for at in paired]
    assert [angles.first for angles in pairs] == approx(paired)
    assert [angles.second for angles in pairs] == approx([-2.0 * at for at in paired])
    assert len(pairs) + pair.unpaired + pair.waiting == len(lefts)


@given(pauses, pauses, st.randoms(use_true_random=False))
def test_how_the_two_wheels_arrivals_interleave_does_not_matter(
    left_steps: list[int], right_steps: list[int], random
) -> None:
    lefts, rights = [*map(left, stamps(left_steps))], [*map(right, stamps(right_steps))]
    turns = [True] * len(lefts) + [False] * len(rights)
    random.shuffle(turns)
    one, other = iter(lefts), iter(rights)
    shuffled, in_order = WheelPair(), WheelPair()
    beyond = right(10_000)
    mixed = feed(shuffled, [next(one) if turn else next(other) for turn in turns] + [beyond])
    plain = feed(in_order, [*lefts, *rights, beyond])
    assert mixed == plain
    assert shuffled.unpaired == in_order.unpaired


def test_a_left_reading_waits_for_the_next_right_one() -> None:
    pair = WheelPair()
    assert feed(pair, [right(0), left(10), right(5)]) == []
    assert pair.waiting == 1
    assert feed(pair, [right(15)]) == [WheelAngles(10 * MS, 10.0, -20.0)]
    assert pair.waiting == 0


def test_readings_of_the_same_moment_need_no_neighbour() -> None:
    assert feed(WheelPair(), [left(10), right(10)]) == [WheelAngles(10 * MS, 10.0, -20.0)]


def test_a_bunch_of_one_wheel_after_a_bunch_of_the_other_is_paired() -> None:
    """Two wheels on two buses, each of which hands over 20 ms at a time."""
    pair = WheelPair()
    pairs = []
    for start in range(0, 200, 20):
        pairs += feed(pair, [right(start + n) for n in (1, 6, 11, 16)])
        pairs += feed(pair, [left(start + n) for n in (0, 5, 10, 15)])
    assert [angles.stamp_ns // MS for angles in pairs] == list(range(5, 180, 5))
    assert pair.unpaired == 1


def test_a_left_reading_before_the_first_right_one_has_no_partner() -> None:
    pair = WheelPair()
    assert feed(pair, [left(5), right(10)]) == []
    assert pair.unpaired == 1


def test_over_a_gap_of_the_right_wheel_nothing_is_guessed() -> None:
    pair = WheelPair(widest_gap_ns=100 * MS)
    pairs = feed(pair, [right(0), left(50), right(101), left(150), right(201)])
    assert [angles.stamp_ns // MS for angles in pairs] == [150]
    assert pair.unpaired == 1


def test_on_both_sides_of_a_gap_the_right_wheel_s_angle_is_known() -> None:
    pairs = feed(WheelPair(), [right(0), left(0), left(400), right(400)])
    assert pairs == [WheelAngles(0, 0.0, 0.0), WheelAngles(400 * MS, 400.0, -800.0)]


def test_no_more_than_so_many_wait_and_the_oldest_give_way() -> None:
    pair = WheelPair(most_waiting=3)
    feed(pair, [right(0), *map(left, range(1, 6))])
    assert (pair.waiting, pair.unpaired) == (3, 2)
    assert [angles.stamp_ns // MS for angles in feed(pair, [right(10)])] == [3, 4, 5]


def test_right_readings_out_of_order_break_nothing() -> None:
    pair = WheelPair()
    pairs = feed(pair, [right(10), left(12), right(5), right(20), left(4), right(30)])
    assert [angles.stamp_ns // MS for angles in pairs] == [12]
    assert pair.unpaired == 1


def steady(name: str, first_ms: int, last_ms: int, offset: float = 0.0) -> list[WheelReading]:
    """A reading every 10 ms of a wheel that turns 1 rad/s, counted from elsewhere by `offset`."""
    return [wheel(name, ms, ms * 1e-3 + offset) for ms in range(first_ms, last_ms, 10)]


def jumping(name: str, back_ms: int, last_ms: int, held: float) -> list[WheelReading]:
    """A wheel that comes back after a restart, going on from the angle it had when it was lost."""
    first, *rest = steady(name, back_ms, last_ms, held - back_ms * 1e-3)
    return [WheelReading(first.stamp_ns, 0, name, first.angle, 1.0, discontinuity=True), *rest]


@pytest.mark.parametrize("name", ["left", "right"])
@pytest.mark.parametrize("back_ms", [560, 1500])
def test_a_wheel_that_restarts_while_both_turn_alike_does_not_turn_the_robot(name: str, back_ms: int) -> None:
    other = "right" if name == "left" else "left"
    lost = [*steady(name, 0, 500), *jumping(name, back_ms, 3000, held=0.49)]
    readings = sorted([*lost, *steady(other, 5, 3000)], key=lambda each: each.stamp_ns)
    pair = WheelPair()
    pairs = feed(pair, readings)
    leads = [each.first - each.second for each in pairs]
    assert leads == approx([leads[0]] * len(leads), abs=1e-9)
    assert pair.restarts == 1
    assert [each.restarted for each in pairs].count(True) == 1
    assert pairs[-1].stamp_ns >= 2980 * MS
    turned = pairs[-1].first - pairs[0].first
    assert turned == approx(3.0 - (back_ms - 490) * 1e-3, abs=0.05)


def test_a_gap_without_a_jump_keeps_what_the_wheels_turned_meanwhile() -> None:
    lefts = [*steady("left", 0, 500), *steady("left", 1500, 3000)]
    readings = sorted([*lefts, *steady("right", 5, 3000)], key=lambda each: each.stamp_ns)
    pair = WheelPair()
    pairs = feed(pair, readings)
    assert pairs[-1].first == approx(pairs[-1].stamp_ns * 1e-9)
    assert pair.restarts == 0


def steered(drive: list[WheelReading], steering: list[WheelReading]) -> tuple[WheelPair, list[WheelAngles]]:
    pair = WheelPair(Tricycle.wheels)
    return pair, feed(pair, sorted([*drive, *steering], key=lambda each: each.stamp_ns))


def test_a_driven_wheel_that_restarts_is_led_on_and_its_steering_stays_as_it_is_told() -> None:
    drive = [*steady("drive", 0, 500), *jumping("drive", 1500, 3000, held=0.49)]
    pair, pairs = steered(drive, steady("steering", 5, 3000, offset=-2.0))
    assert [each.second for each in pairs] == approx([each.stamp_ns * 1e-9 - 2.0 for each in pairs])
    (restart,) = (n for n, each in enumerate(pairs) if each.restarted)
    assert pairs[restart].first == pairs[restart - 1].first
    assert pair.restarts == 1


def test_a_steering_that_restarts_is_no_restart_and_over_its_jump_nothing_is_guessed() -> None:
    steering = [*steady("steering", 5, 500), *jumping("steering", 605, 3000, held=1.0)]
    pair, pairs = steered(steady("drive", 0, 3000), steering)
    assert (pair.restarts, [each.restarted for each in pairs].count(True)) == (0, 0)
    assert [each.first for each in pairs] == approx([each.stamp_ns * 1e-9 for each in pairs])
    assert not any(495 * MS < each.stamp_ns < 605 * MS for each in pairs)
    assert pairs[-1].second == approx(1.0 + pairs[-1].stamp_ns * 1e-9 - 0.605)
