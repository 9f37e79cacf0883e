from collections.abc import Sequence
from dataclasses import replace
from errno import ENXIO, EREMOTEIO
from itertools import pairwise
from math import isnan
from random import Random

from hypothesis import given, settings
from hypothesis.strategies import binary, floats, integers, lists, one_of, sampled_from
from pytest import approx, mark, raises

from echogrid.drivers.bus import I2cMessage, I2cResult, I2cTransfer
from echogrid.drivers.devantech import (
    PATIENCE_NS,
    address_change,
    pulled_down,
    ready,
)
from echogrid.drivers.devantech_gated import echoes_us, gate_us, range_register
from echogrid.drivers.device import Level, Line, State
from echogrid.drivers.readings import Outcome, RangeReading, Reading
from echogrid.drivers.role import Call, RangerRole, Slot
from echogrid.drivers.srf08 import Srf08
from echogrid.emulation.devices.sonar import Sonar
from echogrid.emulation.devices.srf02 import Srf02Chip
from echogrid.emulation.devices.srf08 import Srf08Chip, Srf08Options
from echogrid.emulation.devices.srf235 import Srf235Chip
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.scene import Echo

from .i2c_bench import BUSY, MS, SPEED, TRANSFER_NS, Bench, Joined, room

SLOT = Slot(200 * MS, 30 * MS)
ROLE = RangerRole("left", 0.05, 3.0, SLOT, SPEED)
PING_NS = 18 * MS
"""With the range register at 3 m."""
SET_UP = [b"\x00", b"\x00", b"\x01\x1f", b"\x02\x45", b"\x00\x52"]
"""Both looks, the highest gain, 3 m, and the first ping."""


def echo(*microseconds: int) -> bytes:
    return bytes([9, 80]) + b"".join(time.to_bytes(2, "big") for time in microseconds)


def bench(role: RangerRole = ROLE, settings: Srf08.Settings | None = None) -> Bench:
    play = Bench(Srf08(role, settings or Srf08.Settings()), echo(0))
    play.ping_ns = PING_NS
    return play


def test_the_range_register_of_the_data_sheet() -> None:
    assert range_register(1.0, SPEED) == 23
    assert range_register(6.0, SPEED) == 139
    assert range_register(11.0, SPEED) == 255


@given(floats(0.05, 9.0), floats(310, 360))
def test_the_chip_listens_until_the_farthest_echo_is_back_and_hardly_longer(far: float, speed: float) -> None:
    register = range_register(far, speed)
    assert 0 <= register <= 255
    assert gate_us(register) >= 2e6 * far / speed * 0.999999
    assert register == 0 or gate_us(register - 1) < 2e6 * far / speed


def test_a_reach_beyond_the_range_register_is_refused() -> None:
    for farthest in (11.01, 12.0):
        with raises(ValueError, match=rf"max_m is {farthest}: expected 0.0 to 11.0$"):
            Srf08(RangerRole("left", 0.05, farthest, SLOT, SPEED), Srf08.Settings())


@given(floats(0.0, 20.0), floats(300, 400))
def test_every_reach_has_a_register_of_one_byte_or_is_refused(far: float, speed: float) -> None:
    limit = 256 * 0.043 * speed / 343
    try:
        register = range_register(far, speed)
    except ValueError:
        assert far > limit * 0.999999
    else:
        assert bytes((register,))
        assert far < limit * 1.000001


@mark.parametrize(
    ("key", "value", "allowed"),
    [("address", 0x6F, "0x70 to 0x7f"), ("gain", 32, "0 to 31"), ("gain", -1, "0 to 31")],
)
def test_impossible_settings_are_refused_by_name(key: str, value: int, allowed: str) -> None:
    with raises(ValueError, match=f"{key} is .*: expected {allowed}"):
        Srf08.Settings(**{key: value})


def test_registers_are_decoded() -> None:
    assert echoes_us(bytes.fromhex("09 80 44 5C")) == (17500,)
    assert ready(bytes.fromhex("09 80 44 5C"), 4)
    assert not ready(bytes.fromhex("09 80 44"), 4)
    assert not ready(BUSY * 4, 4)
    assert not ready(b"", 4)
    assert not ready(bytes(4), 4)


def test_it_is_set_up_with_gain_and_range_before_it_fires() -> None:
    play = bench(settings=Srf08.Settings(gain=7))
    play.run(60 * MS)
    assert play.written[:5] == [b"\x00", b"\x00", b"\x01\x07", b"\x02\x45", b"\x00\x52"]


def test_pointer_and_read_are_separate_transfers() -> None:
    device = Srf08(ROLE, Srf08.Settings(address=0x71))
    (pointer,) = device.step(0, []).send
    (read,) = device.step(1, [I2cResult(pointer, 0, 1)]).send
    assert pointer.messages == (I2cMessage(0x71, write=b"\x00"),)
    assert read.messages == (I2cMessage(0x71, read=2),)


def test_it_fires_in_its_slot() -> None:
    play = bench()
    play.run(1000 * MS)
    assert play.fired_ns == [30 * MS, 230 * MS, 430 * MS, 630 * MS, 830 * MS]


@settings(deadline=None)
@given(integers(1, 400), integers(0, 400), floats(0.3, 6.0))
def test_it_never_fires_again_within_58_ms(period_ms: int, offset_ms: int, farthest: float) -> None:
    play = bench(RangerRole("left", 0.05, farthest, Slot(period_ms * MS, offset_ms * MS), SPEED))
    play.run(1000 * MS)
    assert all(b - a >= 58 * MS for a, b in pairwise(play.fired_ns))


def test_without_a_slot_it_fires_as_often_as_it_may() -> None:
    play = bench(RangerRole("left", 0.05, 3.0, None, SPEED))
    play.run(1000 * MS)
    assert len(play.fired_ns) > 10


def test_a_slot_that_comes_late_is_left_to_the_neighbours() -> None:
    play = bench()
    play.run(20 * MS)
    play.now_ns = 60 * MS
    play.run(100 * MS)
    assert play.fired_ns == []
    assert play.device.health(0).counts["missed slots"] == 1


@mark.parametrize(
    ("microseconds", "outcome", "reached"),
    [
        (10_000, Outcome.ECHO, 1.715),
        (0, Outcome.NO_ECHO, 3.0),
        (250, Outcome.TOO_CLOSE, 0.042875),
        (17_500, Outcome.NO_ECHO, 3.0),
        (40_000, Outcome.INVALID, 3.0),
    ],
)
def test_every_result_has_its_meaning_and_its_moment(
    microseconds: int, outcome: Outcome, reached: float
) -> None:
    play = bench()
    play.registers = echo(microseconds)
    play.run(100 * MS)
    (reading,) = play.ranged()
    assert reading.outcome is outcome
    assert reading.distance == approx(reached) if outcome is Outcome.ECHO else isnan(reading.distance)
    assert reading.stamp_ns == 30 * MS + TRANSFER_NS // 2 + round(reached / SPEED * 1e9)
    assert reading.stamp_error_ns == TRANSFER_NS // 2 + 1000
    assert reading.raw == echo(microseconds)
    assert bool(reading.reason) == (outcome is Outcome.INVALID)


def test_a_result_under_another_revision_is_invalid() -> None:
    play = bench()
    play.run(20 * MS)
    play.registers = bytes([77]) + echo(10_000)[1:]
    play.run(80 * MS)
    assert [reading.reason for reading in play.ranged()] == [
        "it reads 4d where it read 09: noise on the bus, or another device?"
    ]


def test_while_it_pings_it_is_polled_every_5_ms() -> None:
    play = bench()
    play.ping_ns = 30 * MS
    play.registers = echo(10_000)
    play.run(100 * MS)
    assert [reading.outcome for reading in play.ranged()] == [Outcome.ECHO]
    assert 2 <= play.device.health(0).counts["busy"] <= 3


@mark.parametrize("errno", [ENXIO, EREMOTEIO])
def test_a_missing_acknowledge_while_it_pings_means_busy(errno: int) -> None:
    play = bench()
    play.registers = echo(10_000)
    play.run(40 * MS)
    play.errno = errno
    play.run(20 * MS)
    play.errno = 0
    play.run(20 * MS)
    assert [reading.outcome for reading in play.ranged()] == [Outcome.ECHO]
    assert play.device.health(play.now_ns).level is Level.OK


def test_a_chip_that_never_gets_ready_gives_one_invalid_reading_and_is_set_up_again() -> None:
    play = bench()
    play.ping_ns = 150 * MS
    play.run(29 * MS)
    play.run(200 * MS)
    (reading,) = play.ranged()
    assert (reading.outcome, reading.reason) == (Outcome.INVALID, "not ready in time")
    play.ping_ns = PING_NS
    play.run(400 * MS)
    assert play.written.count(b"\x01\x1f") == 2
    assert play.ranged()[-1].outcome is Outcome.NO_ECHO


def test_the_wait_for_a_chip_is_bounded() -> None:
    play = bench()
    play.run(20 * MS)
    play.ping_ns = 10_000 * MS
    play.run(30 * MS + 20 * MS + PATIENCE_NS)
    assert len(play.ranged()) == 1


def test_a_missing_chip_is_asked_for_ever_less_often_and_named_in_its_health() -> None:
    play = bench()
    play.errno = EREMOTEIO
    play.run(10_000 * MS)
    assert 5 <= play.device.health(0).counts["missing"] <= 10
    assert play.device.health(0).level is Level.ERROR
    assert "0x70 (7 bit)" in play.device.health(0).message


def test_a_chip_that_comes_back_is_set_up_again() -> None:
    play = bench()
    play.run(100 * MS)
    play.errno = EREMOTEIO
    play.run(1000 * MS)
    play.errno = 0
    play.written.clear()
    play.run(2100 * MS)
    assert play.written[:5] == SET_UP
    assert play.device.health(play.now_ns).level is Level.OK


def test_a_ping_that_was_not_acknowledged_gives_no_reading() -> None:
    play = bench()
    play.run(20 * MS)
    play.errno = EREMOTEIO
    play.run(20 * MS)
    assert play.ranged() == []
    assert play.device.health(0).counts["failed to fire"] == 1


def test_a_ping_under_way_when_the_port_is_lost_is_invalid() -> None:
    play = bench()
    play.run(35 * MS)
    play.device.lost(play.now_ns)
    play.run(150 * MS)
    assert [reading.reason for reading in play.ranged()] == ["port lost"]
    assert play.written.count(b"\x01\x1f") == 2


def test_losing_the_port_between_pings_gives_no_reading() -> None:
    play = bench()
    play.run(20 * MS)
    play.device.lost(play.now_ns)
    play.run(5 * MS)
    assert play.ranged() == []


def test_results_of_others_are_passed_over() -> None:
    device = Srf08(ROLE, Srf08.Settings(address=0x70))
    device.step(0, [])
    other = I2cTransfer((I2cMessage(0x71, write=b"\x00"),))
    assert device.step(1, [I2cResult(other, 0, 1)]).send == ()


def test_two_chips_share_a_line() -> None:
    roles = [RangerRole(name, 0.05, 3.0, Slot(200 * MS, n * 100 * MS), SPEED) for n, name in enumerate("ab")]
    line: Line[I2cResult, I2cTransfer] = Line(
        "i2c", [Srf08(role, Srf08.Settings(address=0x70 + n)) for n, role in enumerate(roles)]
    )
    now_ns, received, readings = 0, list[I2cResult](), list[Reading]()
    while now_ns < 1000 * MS:
        step = line.step(now_ns, received)
        readings += step.readings
        received = [
            I2cResult(transfer, now_ns, now_ns + n, echo(10_000)[: transfer.messages[0].read])
            for n, transfer in enumerate(step.send)
        ]
        now_ns = now_ns + 1 if received else step.deadline_ns
    assert [reading.sensor for reading in readings if isinstance(reading, RangeReading)] == list("babababab")


def test_a_result_that_stays_away_does_not_hang_the_device() -> None:
    device = Srf08(ROLE, Srf08.Settings())
    step = device.step(0, [])
    assert step.send
    again = device.step(step.deadline_ns, [])
    assert device.health(0).counts["unanswered transfers"] == 1
    assert device.step(again.deadline_ns, []).send


def test_health_is_stale_before_the_set_up_and_in_silence() -> None:
    play = bench()
    assert play.device.health(0).level is Level.STALE
    play.run(100 * MS)
    assert play.device.health(100 * MS).level is Level.OK
    assert play.device.health(5000 * MS).level is Level.STALE


def test_health_warns_of_an_invalid_reading() -> None:
    play = bench()
    play.registers = echo(40_000)
    play.run(55 * MS)
    assert "40000 us is longer than it listened" in play.ranged()[0].reason
    assert play.device.health(play.now_ns).level is Level.WARN


@settings(deadline=None)
@given(lists(one_of(binary(max_size=5), sampled_from([4 * BUSY, echo(0), echo(9000)])), max_size=30))
def test_whatever_the_chip_says_each_ping_gives_one_possible_reading(answers: list[bytes]) -> None:
    play = bench()
    for answer in answers:
        play.registers = answer
        play.run(100 * MS)
    play.registers = echo(0)
    play.run(195 * MS)
    assert len(play.fired_ns) - len(play.readings) in (0, 1)
    for reading in play.ranged():
        assert (reading.outcome is Outcome.ECHO) == (ROLE.nearest <= reading.distance < ROLE.farthest)


@mark.parametrize("address", [0x70, 0x79, 0x7F])
def test_the_address_change_is_four_messages_with_the_address_as_the_data_sheet_writes_it(
    address: int,
) -> None:
    messages = address_change(address)
    assert messages == (b"\x00\xa0", b"\x00\xaa", b"\x00\xa5", bytes((0, 2 * address)))


@mark.parametrize("address", [0x00, 0x6F, 0x80, 0xE0])
def test_an_address_that_it_cannot_have_is_refused(address: int) -> None:
    with raises(ValueError, match=f"address is {address:#04x}: expected 0x70 to 0x7f"):
        address_change(address)


@given(binary(min_size=2, max_size=2), binary(min_size=2, max_size=2))
def test_two_who_answer_at_once_pull_bits_down_and_one_alone_does_not(own: bytes, twin: bytes) -> None:
    together = bytes(a & b for a, b in zip(own, twin, strict=True))
    assert pulled_down(together, own) == (together != own)
    assert not pulled_down(own, own)
    assert not pulled_down(own, together)


def test_the_echoes_behind_the_first_are_told_if_they_are_asked_for() -> None:
    play = bench(settings=Srf08.Settings(echoes=4))
    play.registers = echo(5_000, 9_000, 14_000, 0)
    play.run(100 * MS)
    (reading,) = play.ranged()
    assert reading.distance == approx(5_000e-6 * SPEED / 2)
    assert reading.later == approx((9_000e-6 * SPEED / 2, 14_000e-6 * SPEED / 2))


def test_echoes_out_of_order_are_those_of_two_devices() -> None:
    play = bench(settings=Srf08.Settings(echoes=3))
    play.registers = echo(9_000, 5_000, 0)
    play.run(55 * MS)
    assert (
        play.ranged()[0].reason == "echoes after 9000, 5000 us are out of order: two devices at one address?"
    )
    assert play.state is State.CONFLICT


def test_a_chip_that_is_busy_for_too_long_has_lost_its_settings_and_gets_them_again() -> None:
    play = bench()
    play.run(150 * MS)
    play.ping_ns = 65 * MS
    play.run(200 * MS)
    late = play.ranged()[-1]
    assert late.outcome is Outcome.INVALID
    assert late.reason == "busy for 63 ms, not 18: it lost its settings (was its power cut?)"
    assert play.state is State.FAULTY
    assert play.written.count(b"\x01\x1f") == play.written.count(b"\x02\x45") == 2
    play.ping_ns = PING_NS
    play.run(200 * MS)
    assert play.state is State.WELL


def test_one_that_pings_for_65_ms_though_it_was_just_set_up_is_another_device() -> None:
    play = bench()
    play.ping_ns = 65 * MS
    play.registers = bytes((6, 0x80, 0x12, 0x34))
    play.run(1000 * MS)
    assert {reading.reason for reading in play.ranged()} == {"busy for 63 ms, not 18: is it an SRF02?"}
    assert play.state is State.WRONG_DEVICE


def test_one_that_is_slow_by_itself_is_faulty() -> None:
    play = bench()
    play.ping_ns = 45 * MS
    play.run(1000 * MS)
    assert {reading.reason for reading in play.ranged()} == {"busy for 40 ms, not 18: is it failing?"}
    assert play.state is State.FAULTY


@given(integers(0, 255))
def test_it_ranges_in_any_light(light: int) -> None:
    play = bench()
    play.registers = bytes((9, light)) + echo(10_000)[2:]
    play.run(300 * MS)
    assert [reading.distance for reading in play.ranged()] == approx([1.715, 1.715])
    assert play.state is State.WELL


def test_one_that_has_done_too_soon_has_listened_for_less_and_is_set_up_again() -> None:
    play = bench()
    play.run(150 * MS)
    play.ping_ns = 6 * MS
    play.run(120 * MS)
    early = play.ranged()[-1]
    assert early.outcome is Outcome.INVALID
    assert early.reason.startswith("ready within 13 ms, not 18: did another program set it up")
    assert play.state is State.FAULTY
    assert play.written.count(b"\x01\x1f") == play.written.count(b"\x02\x45") == 2
    play.ping_ns = PING_NS
    play.run(200 * MS)
    assert play.state is State.WELL


def test_a_look_that_came_too_late_to_tell_tells_nothing() -> None:
    class Slow(Bench):
        def result(self, transfer: I2cTransfer) -> I2cResult:
            self.now_ns += 2 * MS if self.fired_ns else 0
            return super().result(transfer)

    play = Slow(Srf08(ROLE, Srf08.Settings()), echo(0))
    play.run(1000 * MS)
    assert {reading.outcome for reading in play.ranged()} == {Outcome.NO_ECHO}


def test_its_settings_are_written_again_behind_every_sixteenth_answer() -> None:
    play = bench()
    play.run(16 * 200 * MS)
    assert len(play.ranged()) == 16
    assert play.written.count(b"\x01\x1f") == play.written.count(b"\x02\x45") == 2
    assert play.device.health(play.now_ns).counts["set-ups"] == 1
    play.run(16 * 200 * MS)
    assert play.written.count(b"\x02\x45") == 3


@settings(deadline=None)
@given(integers(0, 68), sampled_from([0.5, 2.9]))
def test_a_range_written_behind_its_back_makes_nothing_look_free_for_longer_than_sixteen_pings(
    register: int, distance: float
) -> None:
    chip = Srf08Chip("front", room(distance), Random(1))
    joined = Joined([chip], [Srf08(ROLE, Srf08.Settings())])
    joined.run(1000 * MS)
    chip.write(bytes((2, register)), joined.clock.now_ns())
    readings = joined.run(4000 * MS)
    wrong = [reading for reading in readings if reading.outcome is Outcome.NO_ECHO]
    assert len(wrong) <= 16
    assert not (wrong and (register + 1) * 0.043 < 0.7 * ROLE.farthest)
    assert {reading.outcome for reading in readings[17:]} == {Outcome.ECHO}
    assert joined.states() == [State.WELL]


def test_a_gain_written_behind_its_back_is_its_own_again_within_sixteen_pings() -> None:
    faint = Surroundings(lambda fire_ns: (Echo(1.0, 10.0, "wall"),), SPEED)
    chip = Srf08Chip("front", faint, Random(1))
    joined = Joined([chip], [Srf08(ROLE, Srf08.Settings())])
    joined.run(1000 * MS)
    chip.write(b"\x01\x00", joined.clock.now_ns())
    outcomes = [reading.outcome for reading in joined.run(5000 * MS)]
    assert 0 < outcomes.count(Outcome.NO_ECHO) <= 16
    assert outcomes[16:] == [Outcome.ECHO] * len(outcomes[16:])


def test_an_srf235_at_its_address_is_noticed_by_its_haste() -> None:
    joined = Joined([Srf235Chip("two", room(1.0), Random(1))], [Srf08(ROLE, Srf08.Settings())])
    readings = joined.run(2000 * MS)
    assert {reading.outcome for reading in readings} == {Outcome.INVALID}
    assert joined.states() == [State.FAULTY]
    assert joined.messages()[0].endswith("is it an SRF235?")


def test_registers_that_never_say_the_same_are_garbled() -> None:
    class Noise(Bench):
        random = Random(1)

        def result(self, transfer: I2cTransfer) -> I2cResult:
            self.registers = self.random.randbytes(4)
            return super().result(transfer)

    play = Noise(Srf08(ROLE, Srf08.Settings()), b"")
    play.run(2000 * MS)
    health = play.device.health(play.now_ns)
    assert health.state is State.GARBLED
    assert "is the bus too fast, too long, without pull-ups?" in health.message
    assert play.fired_ns == []


def test_a_second_device_at_its_address_is_told_until_it_goes() -> None:
    play = bench()
    play.run(100 * MS)
    play.registers = bytes((9 & 0xFC, 80, 0, 0))
    play.run(2000 * MS)
    health = play.device.health(play.now_ns)
    assert health.state is State.CONFLICT
    assert "it reads 08 where it read 09: give two devices two addresses" in health.message
    assert len([reading for reading in play.ranged() if reading.outcome is Outcome.INVALID]) == 1
    play.registers = echo(0)
    play.run(2200 * MS)
    assert play.state is State.WELL


def test_a_chip_that_was_exchanged_for_an_older_one_is_taken() -> None:
    play = bench()
    play.run(100 * MS)
    play.errno = EREMOTEIO
    play.run(1000 * MS)
    play.errno, play.registers = 0, bytes((8, 80, 0, 0))
    play.run(2200 * MS)
    assert play.state is State.WELL


def called_chips(count: int, *distances: float) -> Joined:
    """Chips on one bus, each before its own wall; the first one's driver fires them all."""
    slot = Slot(100 * MS, 0)
    chips = [
        Srf08Chip(str(n), room(distance), Random(n), Srf08Options(0x70 + n))
        for n, distance in enumerate(distances)
    ]
    roles = [RangerRole(str(n), 0.05, 3.0, slot, SPEED, Call.CALLED) for n in range(count)]
    roles[0] = replace(roles[0], call=Call.ALL)
    return Joined(chips, [Srf08(role, Srf08.Settings(0x70 + n)) for n, role in enumerate(roles)])


def fired_at(readings: Sequence[RangeReading]) -> dict[str, list[int]]:
    """When each fired, by the stamps of its echoes."""
    return {
        name: [
            reading.stamp_ns - round(reading.distance / SPEED * 1e9)
            for reading in readings
            if reading.sensor == name
        ]
        for name in "012"
    }


def test_one_general_call_fires_three_chips_at_once_and_each_reads_its_own_wall() -> None:
    joined = called_chips(3, 1.0, 1.5, 2.0)
    readings = joined.run(1050 * MS)
    assert {reading.outcome for reading in readings} == {Outcome.ECHO}
    for name, distance in zip("012", (1.0, 1.5, 2.0), strict=True):
        own = [reading.distance for reading in readings if reading.sensor == name]
        assert own == approx([distance] * 10, abs=0.0002)
    fired = fired_at(readings)
    assert fired["0"] == fired["1"] == fired["2"]
    assert joined.states() == [State.WELL] * 3


def test_a_called_chip_that_misses_a_call_is_set_up_again_and_joins_in() -> None:
    joined = called_chips(3, 1.0, 1.5, 2.0)
    joined.run(1000 * MS)
    joined.chips[1].fault("off", joined.clock.now_ns(), 500 * MS)
    readings = joined.run(500 * MS)
    assert joined.states() == [State.WELL, State.MISSING, State.WELL]
    assert [reading.outcome for reading in readings if reading.sensor == "1"] == [Outcome.INVALID]
    joined.run(1000 * MS)
    readings = joined.run(1000 * MS)
    assert joined.states() == [State.WELL] * 3
    assert joined.count("set-ups") == [1, 2, 1]
    fired = fired_at(readings)
    assert fired["0"] == fired["1"] == fired["2"]


@mark.parametrize("verb", ["off", "unplug"])
def test_the_others_go_on_while_the_one_that_calls_is_missing(verb: str) -> None:
    joined = called_chips(3, 1.0, 1.5, 2.0)
    joined.run(1000 * MS)
    joined.chips[0].fault(verb, joined.clock.now_ns(), 4000 * MS)
    joined.run(2000 * MS)
    readings = joined.run(2000 * MS)
    assert joined.states() == [State.MISSING, State.WELL, State.WELL]
    assert len([reading for reading in readings if reading.sensor == "1"]) >= 16
    joined.run(2500 * MS)
    assert joined.states() == [State.WELL] * 3


@settings(deadline=None)
@given(integers(0, 2), integers(0, 200), integers(1, 400))
def test_whenever_one_of_them_was_away_it_is_back_within_three_seconds(
    which: int, begins_ms: int, lasts_ms: int
) -> None:
    joined = called_chips(3, 1.0, 1.5, 2.0)
    joined.run(1000 * MS + begins_ms * MS)
    joined.chips[which].fault("off", joined.clock.now_ns(), lasts_ms * MS)
    joined.run(3000 * MS + lasts_ms * MS)
    assert joined.states() == [State.WELL] * 3
    assert len(joined.run(1000 * MS)) == 30


def test_a_called_chip_that_did_not_hear_a_call_does_not_tell_the_ping_before_as_a_new_one() -> None:
    joined = called_chips(2, 1.0, 1.5)
    joined.run(1060 * MS)
    joined.chips[1].fault("unplug", joined.clock.now_ns(), 42 * MS)
    own = [reading for reading in joined.run(80 * MS) if reading.sensor == "1"]
    assert [(reading.outcome, reading.reason[:12]) for reading in own] == [(Outcome.INVALID, "ready within")]


def test_a_called_chip_whose_power_was_cut_between_two_calls_is_set_up_again() -> None:
    joined = called_chips(2, 1.0, 1.5)
    joined.run(1060 * MS)
    joined.chips[1].fault("off", joined.clock.now_ns(), 10 * MS)
    readings = joined.run(200 * MS)
    reasons = [reading.reason for reading in readings if reading.sensor == "1"]
    assert reasons[0].endswith("it lost its settings (was its power cut?)")
    joined.run(300 * MS)
    assert joined.states() == [State.WELL] * 2
    assert joined.count("set-ups") == [1, 2]


def test_a_chip_whose_reach_is_long_lost_its_power_unnoticed_but_gets_its_settings_again() -> None:
    chip = Srf08Chip("far", room(1.0), Random(1))
    joined = Joined([chip], [Srf08(RangerRole("far", 0.05, 9.0, SLOT, SPEED), Srf08.Settings(gain=3))])
    joined.run(1000 * MS)
    chip.fault("off", joined.clock.now_ns(), 10 * MS)
    readings = joined.run(1000 * MS)
    assert {reading.outcome for reading in readings} == {Outcome.ECHO}
    assert joined.count("set-ups") == [1]
    faint = Surroundings(lambda fire_ns: (Echo(8.0, 10.0, "wall"),), SPEED)
    chip.sonar = Sonar(faint, chip.faults, Random(1))
    assert joined.run(1000 * MS)[-1].outcome is Outcome.ECHO
    assert joined.run(1400 * MS)[-1].outcome is Outcome.NO_ECHO


def test_an_srf02_at_its_address_is_noticed() -> None:
    joined = Joined([Srf02Chip("two", room(1.0), Random(1))], [Srf08(ROLE, Srf08.Settings())])
    readings = joined.run(2000 * MS)
    assert {reading.outcome for reading in readings} == {Outcome.INVALID}
    assert joined.states() == [State.WRONG_DEVICE]
    assert joined.messages()[0].endswith("is it an SRF02?")


def test_two_of_a_kind_at_one_address_are_not_noticed_and_read_too_near() -> None:
    """There is nothing in which they differ: why two devices need two addresses."""
    chips = [Srf08Chip(str(n), room(distance), Random(n)) for n, distance in enumerate((1.0, 1.1))]
    joined = Joined(chips, [Srf08(ROLE, Srf08.Settings())])
    readings = joined.run(1000 * MS)
    flight_us = round(2e6 / SPEED) & round(2.2e6 / SPEED)
    assert [reading.distance for reading in readings] == approx(
        [flight_us * 1e-6 * SPEED / 2] * len(readings)
    )
    assert joined.states() == [State.WELL]


def test_a_bad_contact_is_told_in_its_bad_spells_and_gives_no_false_echo() -> None:
    joined = Joined([Srf08Chip("front", room(1.5), Random(1))], [Srf08(ROLE, Srf08.Settings())])
    suffered = joined.suffer("intermittent")
    assert suffered.states[State.MISSING] > 0
    assert suffered.states[State.WELL] > 0
    assert set(suffered.outcomes) <= {Outcome.ECHO, Outcome.INVALID}


@mark.parametrize(("pulled", "state"), [(0b10, State.CONFLICT), (0, State.WELL)])
def test_another_device_is_noticed_if_it_pulls_down_a_bit_of_the_revision(pulled: int, state: State) -> None:
    twin = Random(1).randbytes(64)[0]
    assert not twin & 0b10
    chip = Srf08Chip("front", room(1.0), Random(1), Srf08Options(revision=twin | pulled))
    joined = Joined([chip], [Srf08(ROLE, Srf08.Settings())])
    joined.run(1000 * MS)
    chip.fault("address_conflict", joined.clock.now_ns())
    joined.run(2000 * MS)
    assert joined.states() == [state]
    chip.clear(joined.clock.now_ns())
    joined.run(2500 * MS)
    assert joined.states() == [State.WELL]
