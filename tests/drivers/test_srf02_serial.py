from errno import EPROTO, ETIMEDOUT
from itertools import pairwise
from random import Random

from hypothesis import given, settings
from hypothesis.strategies import binary, integers, lists, one_of, sampled_from, sets
from pytest import approx, mark, raises

from echogrid.drivers.bus import Break, SerialTransfer
from echogrid.drivers.device import State
from echogrid.drivers.readings import Outcome, RangeReading
from echogrid.drivers.role import Call, RangerRole, Slot
from echogrid.drivers.srf02_serial import Srf02Serial, address_change
from echogrid.emulation.devices.srf02_serial import Srf02SerialOptions, Srf02SerialSensor

from .serial_bench import MS, SPEED, Bench, Joined, room

SLOT = Slot(200 * MS, 30 * MS)
ROLE = RangerRole("front", 0.15, 4.0, SLOT, SPEED)
SENT_NS = MS
"""In the bench a request has passed after that."""


def bench(*answers: bytes | int, role: RangerRole = ROLE, address: int = 0) -> Bench:
    """A ranger played by hand: these are its answers, the last of them for ever."""
    said = list(answers)

    def reply(send: tuple[bytes | Break, ...], now_ns: int) -> bytes | int:
        (request,) = send
        assert isinstance(request, bytes)
        if request[1] != 0x5E:
            return b""
        return said.pop(0) if len(said) > 1 else said[0]

    return Bench(Srf02Serial(role, Srf02Serial.Settings(address=address)), reply)


def test_it_is_looked_for_twice_fired_in_its_turn_and_asked_70_ms_later() -> None:
    play = bench(b"\x16\xc6", address=3)
    play.run(130 * MS)
    times = [at_ns for at_ns, _ in play.asked]
    assert play.sent()[:4] == [b"\x03\x5e", b"\x03\x5e", b"\x03\x52", b"\x03\x5e"]
    assert times[2] == 30 * MS
    assert times[3] == 30 * MS + SENT_NS + 70 * MS


def test_the_golden_300_cm() -> None:
    play = bench(b"\x44\x56")
    play.run(130 * MS)
    (reading,) = play.ranged()
    assert (reading.outcome, reading.raw) == (Outcome.ECHO, b"\x44\x56")
    assert reading.distance == approx(3.0, abs=0.001)
    assert reading.stamp_ns == 30 * MS + SENT_NS + round(reading.distance / SPEED * 1e9)


@mark.parametrize(
    ("answer", "outcome"),
    [
        (b"\x00\x00", Outcome.NO_ECHO),
        (b"\x5d\xc0", Outcome.NO_ECHO),
        (b"\x02\x00", Outcome.TOO_CLOSE),
        (b"\xff\xff", Outcome.INVALID),
    ],
)
def test_every_answer_has_its_meaning(answer: bytes, outcome: Outcome) -> None:
    play = bench(answer)
    play.run(130 * MS)
    assert [reading.outcome for reading in play.ranged()] == [outcome]


def test_its_first_six_pings_hear_nothing_within_28_cm() -> None:
    play = bench(b"\x05\xb0")
    play.run(2_000 * MS)
    outcomes = [reading.outcome for reading in play.ranged()]
    assert outcomes[:7] == [Outcome.TOO_CLOSE] * 6 + [Outcome.ECHO]


def test_after_each_set_up_it_may_just_have_got_its_power() -> None:
    near = b"\x05\xb0"
    play = bench(*[near] * 30, ETIMEDOUT, near)
    play.run(8_000 * MS)
    outcomes = [reading.outcome for reading in play.ranged()]
    back = outcomes[outcomes.index(Outcome.INVALID) + 1 :]
    assert outcomes.index(Outcome.INVALID) > 7
    assert back[:7] == [Outcome.TOO_CLOSE] * 6 + [Outcome.ECHO]


def test_a_range_far_from_the_one_before_is_asked_for_twice() -> None:
    play = bench(b"\x11\x00", b"\x11\x00", b"\x20\x00", b"\x20\x00", b"\x20\x10", b"\x28\x00", b"\x28\x00")
    play.run(530 * MS)
    asked = play.sent().count(b"\x00\x5e")
    assert [reading.raw for reading in play.ranged()] == [b"\x20\x00", b"\x20\x10", b"\x28\x00"]
    assert asked == 2 + 2 + 1 + 2


def test_what_it_says_once_and_not_again_is_garbled() -> None:
    play = bench(b"\x11\x00", b"\x11\x00", b"\x20\x00", b"\x30\x00")
    play.run(130 * MS)
    assert [reading.outcome for reading in play.ranged()] == [Outcome.ECHO]
    play = bench(b"\x11\x00", b"\x11\x00", *(bytes((n, 0)) for n in range(0x20, 0x60, 8)))
    play.run(115 * MS)
    (reading,) = play.ranged()
    assert (reading.outcome, reading.raw) == (Outcome.INVALID, b"\x30\x00\x38\x00")
    assert "noise, or two devices at one address" in reading.reason


def test_silence_after_a_ping_is_one_invalid_reading_and_the_ranger_is_missing() -> None:
    play = bench(b"\x11\x00", b"\x11\x00", ETIMEDOUT)
    play.run(200 * MS)
    assert [reading.reason for reading in play.ranged()] == ["not ready in time"]
    assert play.state is State.MISSING
    assert "address 0: check its power, wires and address" in play.message


def test_noise_at_the_set_up_is_garbled() -> None:
    play = bench(EPROTO)
    play.run(100 * MS)
    assert (play.state, play.ranged()) == (State.GARBLED, [])
    assert "two devices at one address, or not 9600 baud" in play.message


def test_its_own_request_heard_back_is_no_answer() -> None:
    play = bench(b"\x09\x5e", address=9)
    play.run(100 * MS)
    assert (play.state, "join no RX to TX" in play.message) == (State.GARBLED, True)


def test_a_turn_that_only_listens_is_told_so_and_its_answer_is_in_centimetres() -> None:
    role = RangerRole("front", 0.15, 4.0, Slot(200 * MS, 30 * MS, listens_every=1), SPEED)
    play = bench(b"\x00\x64", role=role)
    play.run(130 * MS)
    (reading,) = play.ranged()
    assert (reading.listened, reading.distance) == (True, approx(1.0))
    assert b"\x00\x57" in play.sent()


def test_requests_have_two_bytes_and_replies_no_frame() -> None:
    play = bench(b"\x11\x00")
    play.run(130 * MS)
    assert {len(request) for request in play.sent()} == {2}
    assert {transfer.framed for transfer in play.transfers if transfer.reply_length} == {False}


def test_the_port_has_two_stop_bits() -> None:
    assert Srf02Serial.port_options == {"baud": 9600, "stop_bits": 2}


@mark.parametrize("address", [-1, 16])
def test_impossible_addresses_are_refused_by_name(address: int) -> None:
    with raises(ValueError, match=f"address is {address}: expected 0 to 15"):
        Srf02Serial.Settings(address=address)
    with raises(ValueError, match=f"address is {address}: expected 0 to 15"):
        address_change(0, address)


def test_it_is_moved_by_four_messages() -> None:
    assert address_change(2, 7) == tuple(
        SerialTransfer((bytes((2, last)),)) for last in (0xA0, 0xAA, 0xA5, 0x07)
    )


def test_a_reach_beyond_its_listening_is_refused() -> None:
    with raises(ValueError, match=r"max_m is 12.0: expected 0.0 to 11.15"):
        Srf02Serial(RangerRole("front", 0.15, 12.0, SLOT, SPEED), Srf02Serial.Settings())


def test_it_obeys_no_general_call() -> None:
    with raises(ValueError, match="obeys no general call"):
        Srf02Serial(RangerRole("front", 0.15, 4.0, SLOT, SPEED, Call.ALL), Srf02Serial.Settings())


ANSWERS = one_of(binary(min_size=1, max_size=5), sampled_from([b"\x11\x00", ETIMEDOUT, EPROTO]))


@given(lists(ANSWERS, min_size=1, max_size=12))
def test_whatever_it_says_each_ping_gives_at_most_one_reading_and_echoes_are_possible(
    answers: list[bytes | int],
) -> None:
    play = bench(*answers, b"\x11\x00")
    play.run(4_000 * MS)
    readings = play.ranged()
    assert len(readings) <= play.sent().count(b"\x00\x52")
    assert all(later.stamp_ns > sooner.stamp_ns for sooner, later in pairwise(readings))
    for reading in readings:
        assert (reading.outcome is Outcome.ECHO) == (ROLE.nearest <= reading.distance < ROLE.farthest)
    play.run(20_000 * MS)
    assert play.state is State.WELL


# The same with the emulated ranger, on the clock that jumps.


def joined(
    count: int, distance: float = 1.0, pings: list[list[int]] | None = None
) -> tuple[Joined, list[Srf02SerialSensor]]:
    """So many on one line, each before a wall of its own, 10 cm apart; the times of their pings."""
    noted = pings or [[] for _ in range(count)]
    sensors = [
        Srf02SerialSensor(
            str(n), room(distance + n / 10, pings=noted[n]), Random(n), Srf02SerialOptions(address=n)
        )
        for n in range(count)
    ]
    devices = [
        Srf02Serial(RangerRole(str(n), 0.1, 4.0, slot(n, count), SPEED), Srf02Serial.Settings(address=n))
        for n in range(count)
    ]
    return Joined(sensors, devices), sensors


def slot(number: int, count: int) -> Slot:
    return Slot(max(count, 2) * 70 * MS, number * 70 * MS)


@mark.parametrize("distance", [0.29, 0.5, 1.0, 2.345, 3.9])
def test_it_sees_the_scene_to_a_microsecond(distance: float) -> None:
    line, _ = joined(1, distance)
    line.run(500 * MS)
    readings = line.run(2_000 * MS)
    assert {reading.outcome for reading in readings} == {Outcome.ECHO}
    assert [reading.distance for reading in readings] == approx([distance] * len(readings), abs=0.0002)


def test_an_object_within_28_cm_is_seen_when_it_has_tuned_itself() -> None:
    line, _ = joined(1, 0.2)
    early = line.run(6 * 140 * MS)
    late = line.run(2_000 * MS)[2:]
    assert {reading.outcome for reading in early} == {Outcome.NO_ECHO, Outcome.TOO_CLOSE}
    assert {round(reading.distance, 3) for reading in late} == {0.2}


def test_sixteen_on_a_line_ping_in_their_turns_and_see_each_its_own_wall() -> None:
    line, _ = joined(16)
    line.run(1_500 * MS)
    readings = line.run(16 * 70 * 5 * MS)
    assert len(readings) == 16 * 5
    for reading in readings:
        assert reading.distance == approx(1.0 + int(reading.sensor) / 10, abs=0.0002)
    assert line.count("missed slots") == [0] * 16


def pings_of(count: int, verb: str, failing: set[int]) -> tuple[list[float], list[RangeReading]]:
    """How late (ms) the others ping within their slots, and what they see, in four rounds."""
    pings: list[list[int]] = [[] for _ in range(count)]
    line, sensors = joined(count, pings=pings)
    for n in failing:
        sensors[n].fault(verb, line.clock.now_ns())
    line.run(2 * count * 70 * MS)
    for each in pings:
        each.clear()
    readings = [each for each in line.run(4 * count * 70 * MS) if int(each.sensor) not in failing]
    late = [
        (at_ns - slot(n, count).offset_ns) % slot(n, count).period_ns / MS
        for n, each in enumerate(pings)
        for at_ns in each
        if n not in failing
    ]
    return late, readings


@settings(max_examples=25, deadline=None)
@given(integers(2, 16), sets(integers(0, 15)))
def test_silent_ones_cost_the_others_no_ping_and_no_moment(count: int, silent: set[int]) -> None:
    silent = {n for n in silent if n < count}
    late, readings = pings_of(count, "off", silent)
    alive = count - len(silent)
    assert 4 * alive - 1 <= len(late) <= 4 * alive + 1
    assert abs(len(readings) - len(late)) <= 1
    assert max(late, default=0.0) < 2.5
    for reading in readings:
        assert reading.distance == approx(1.0 + int(reading.sensor) / 10, abs=0.0002)


@settings(max_examples=25, deadline=None)
@given(
    integers(2, 16),
    sampled_from(["garbage", "delayed", "slow", "intermittent", "address_conflict"]),
    sets(integers(0, 15)),
)
def test_failing_ones_delay_the_others_by_a_time_out_at_most_and_never_speak_for_them(
    count: int, verb: str, failing: set[int]
) -> None:
    failing = {n for n in failing if n < count}
    late, readings = pings_of(count, verb, failing)
    assert max(late, default=0.0) < 2.5 + 30.0
    for reading in readings:
        if reading.outcome is Outcome.ECHO:
            assert reading.distance == approx(1.0 + int(reading.sensor) / 10, abs=0.0002)


@mark.parametrize(
    ("verb", "state", "outcomes"),
    [
        ("off", State.MISSING, set()),
        ("unplug", State.MISSING, set()),
        ("garbage", State.GARBLED, set()),
        ("slow", State.MISSING, {Outcome.INVALID}),
        ("delayed", State.MISSING, set()),
        ("address_conflict", State.GARBLED, set()),
        ("stuck", State.WELL, {Outcome.ECHO}),
        ("wrong", State.WELL, {Outcome.ECHO}),
    ],
)
def test_each_fault_has_its_state_and_the_others_go_on(
    verb: str, state: State, outcomes: set[Outcome]
) -> None:
    line, sensors = joined(3)
    line.run(2_000 * MS)
    sensors[1].fault(verb, line.clock.now_ns())
    line.run(3_000 * MS)
    readings = line.run(2_100 * MS)
    assert line.states() == [State.WELL, state, State.WELL]
    assert {reading.outcome for reading in readings if reading.sensor == "1"} == outcomes
    for n in ("0", "2"):
        own = [reading for reading in readings if reading.sensor == n]
        assert 9 <= len(own) <= 11
        assert [reading.distance for reading in own] == approx([1.0 + int(n) / 10] * len(own), abs=0.0002)
    sensors[1].clear(line.clock.now_ns())
    line.run(4_000 * MS)
    readings = line.run(1_050 * MS)
    assert line.states() == [State.WELL] * 3
    assert {round(reading.distance, 3) for reading in readings if reading.sensor == "1"} == {1.1}


def test_a_bad_contact_comes_and_goes_and_gives_no_wrong_reading() -> None:
    line, sensors = joined(2)
    sensors[0].fault("intermittent", line.clock.now_ns())
    readings = line.run(30_000 * MS)
    own = [reading for reading in readings if reading.sensor == "0"]
    assert {reading.outcome for reading in own} >= {Outcome.ECHO, Outcome.INVALID}
    assert {round(reading.distance, 3) for reading in own if reading.outcome is Outcome.ECHO} == {1.0}
    sensors[0].clear(line.clock.now_ns())
    line.run(4_000 * MS)
    assert line.states() == [State.WELL] * 2


def test_a_power_cut_costs_a_few_pings_and_its_first_ones_hear_nothing_near_by() -> None:
    line, sensors = joined(1, 0.2)
    line.run(3_000 * MS)
    sensors[0].fault("off", line.clock.now_ns(), 300 * MS)
    outcomes = [reading.outcome for reading in line.run(4_000 * MS)]
    back = outcomes[outcomes.index(Outcome.INVALID) + 1 :]
    assert Outcome.ECHO not in back[:3]
    assert back[-3:] == [Outcome.ECHO] * 3


def test_an_unplugged_adapter_loses_the_port_and_all_are_set_up_anew() -> None:
    line, _ = joined(3)
    line.run(2_000 * MS)
    line.bus.fault("unplug", line.clock.now_ns(), 500 * MS)
    line.run(300 * MS)
    assert line.pump.trouble
    line.run(4_000 * MS)
    assert line.states() == [State.WELL] * 3
    assert line.count("set-ups") == [2, 2, 2]
