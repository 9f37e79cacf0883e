from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from echogrid.drivers import registry
from echogrid.drivers.bus import Break, I2cMessage, I2cTransfer, Result, SerialTransfer
from echogrid.drivers.commanded import CommandedRanger
from echogrid.drivers.course import Course
from echogrid.drivers.pace import TURNAROUND_NS, Pace, Rehearsal
from echogrid.drivers.role import RangerRole
from echogrid.drivers.serial_talk import exactly
from echogrid.drivers.srf08 import Srf08
from echogrid.drivers.urm_modbus import Urm15

MS = 1_000_000
IDLE = I2cTransfer(())
COMMANDED = [
    driver
    for driver in map(registry.driver, registry.BUILT_IN)
    if isinstance(driver, type) and issubclass(driver, CommandedRanger)
]
PACE = Pace(ping_ns=20 * MS, rest_ns=58 * MS, fire_ns=1 * MS, collect_ns=2 * MS)


def course_of(*wishes: I2cTransfer | int) -> Course[I2cTransfer, int]:
    """Yields these; how many bytes came back."""
    count = 0
    for wish in wishes:
        result = yield wish
        count += len(result.data) if not isinstance(wish, int) else 0
    return count


def spoken(transfer: SerialTransfer) -> Course[SerialTransfer, bytes]:
    result: Result[SerialTransfer] = yield transfer
    return result.data


@given(st.lists(st.integers(1, 30), max_size=5), st.sampled_from([100_000, 400_000]))
def test_bytes_on_i2c_take_nine_bits_each_and_waits_none(reads: list[int], bit_rate: int) -> None:
    transfers = [I2cTransfer((I2cMessage(0x70, write=b"\0"), I2cMessage(0x70, read=n))) for n in reads]
    rehearsal = Rehearsal(IDLE, bit_rate)
    assert rehearsal.play(course_of(5 * MS, *transfers)) == sum(reads)
    bits = sum(9 * (2 + 1 + n) + 2 * 2 for n in reads)
    assert rehearsal.busy_ns == pytest.approx(bits * 1e9 / bit_rate, abs=len(reads))


def test_what_comes_after_a_wait_begins_then() -> None:
    rehearsal = Rehearsal(IDLE, 100_000)
    write = I2cTransfer((I2cMessage(0x70, write=b"\0"),))
    rehearsal.play(course_of(write, 5 * MS, write))
    assert rehearsal.spans == [(0, 200_000), (5 * MS, 5 * MS + 200_000)]


def test_a_request_a_break_and_the_reply_that_it_expects_take_their_time_on_a_serial_line() -> None:
    transfer = SerialTransfer((Break(0.001), b"\x01\x54"), exactly(2), 100 * MS)
    rehearsal = Rehearsal(SerialTransfer(()), 9600)
    assert rehearsal.play(spoken(transfer)) == bytes(2)
    assert rehearsal.busy_ns == pytest.approx(1 * MS + 4 * 11e9 / 9600 + TURNAROUND_NS, abs=2)


def test_a_reply_without_a_frame_ends_with_a_pause() -> None:
    rehearsal = Rehearsal(SerialTransfer(()), 9600)
    rehearsal.play(spoken(SerialTransfer((b"\x01\x54",), exactly(2), framed=False)))
    assert rehearsal.busy_ns == pytest.approx(6 * 11e9 / 9600 + TURNAROUND_NS, abs=2)


def test_the_silences_before_and_behind_a_reply_are_the_bus_s_too() -> None:
    rehearsal = Rehearsal(SerialTransfer(()), 115_200)
    rehearsal.play(spoken(SerialTransfer((bytes(8),), exactly(8), quiet_ns=2 * MS)))
    assert rehearsal.busy_ns == pytest.approx(4 * MS + 16 * 11e9 / 115_200 + TURNAROUND_NS, abs=16)


def test_a_course_without_end_is_left() -> None:
    rehearsal = Rehearsal(IDLE, 100_000)
    assert rehearsal.play(course_of(*[1] * 1000)) is None
    assert rehearsal.busy_ns == 0


def test_a_ranger_fires_again_when_it_has_answered_and_rested() -> None:
    assert PACE.period_ns == 58 * MS
    assert replace(PACE, rest_ns=10 * MS).period_ns == 23 * MS


def test_one_that_answers_the_command_itself_holds_its_bus_until_then() -> None:
    assert PACE.held_ns == 1 * MS
    assert replace(PACE, holds_bus=True).held_ns == 21 * MS


def test_it_needs_its_bus_for_the_command_and_when_the_ping_is_over() -> None:
    pace = replace(PACE, pinged_ns=600_000)
    assert pace.busy == ((0, 1 * MS), (20_400_000, 22_600_000))
    assert replace(pace, collect_ns=0, holds_bus=True).busy == ((0, 21 * MS),)
    assert (9_800_000, 11 * MS) in replace(pace, looks=((10 * MS, 11 * MS),)).busy


def test_the_ping_of_a_urm15_is_between_its_command_and_the_reply() -> None:
    urm15 = Urm15(RangerRole("front", 0.3, 5.0, None, 343.0), Urm15.Settings(baud=115_200))
    pace, byte_ns = urm15.pace(115_200), 11e9 / 115_200
    assert pace.fire_ns == pytest.approx(16 * byte_ns + 2 * 1.75 * MS + TURNAROUND_NS, abs=20)
    assert pace.pinged_ns == pytest.approx((24 * byte_ns + 1.75 * MS + TURNAROUND_NS) / 2, abs=20)
    assert pace.collect_ns == pytest.approx(21 * byte_ns + 2 * 1.75 * MS + TURNAROUND_NS, abs=25)


def test_who_was_asked_for_its_pace_is_as_good_as_new() -> None:
    """It tries to set the ranger up first, as before."""
    asked, other = (Srf08(RangerRole("front", 0.04, 3.0, None, 343.0), Srf08.Settings()) for _ in range(2))
    asked.pace(100_000)
    asked.pace(100_000)
    assert asked.pace(100_000) == other.pace(100_000)
    assert asked.step(0, ()).send == other.step(0, ()).send
    assert asked.health(0) == other.health(0)


def test_more_echoes_take_longer_to_collect() -> None:
    role = RangerRole("front", 0.04, 3.0, None, 343.0)
    one, all_ = (Srf08(role, Srf08.Settings(echoes=count)).pace(100_000) for count in (1, 17))
    assert all_.collect_ns - one.collect_ns == 16 * 2 * 9 * 10_000
    assert (all_.ping_ns, all_.fire_ns) == (one.ping_ns, one.fire_ns)


@pytest.mark.parametrize("driver", COMMANDED)
def test_every_commanded_ranger_knows_its_pace(driver: Any) -> None:
    pace = driver(RangerRole("front", 0.1, 1.0, None, 343.0), driver.Settings()).pace(9600)
    assert 0 < pace.ping_ns < 1000 * MS
    assert pace.period_ns >= pace.ping_ns
    assert pace.holds_bus or pace.fire_ns > 0
