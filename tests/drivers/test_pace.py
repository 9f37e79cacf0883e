from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from echogrid.drivers import registry
from echogrid.drivers.bus import Break, I2cMessage, I2cTransfer, Result, SerialTransfer
from echogrid.drivers.commanded import CommandedRanger
from echogrid.drivers.course import Course
from echogrid.drivers.pace import Pace, bus_time
from echogrid.drivers.role import RangerRole
from echogrid.drivers.serial_talk import exactly
from echogrid.drivers.srf08 import Srf08

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
    busy_ns, count = bus_time(course_of(5 * MS, *transfers), IDLE, bit_rate)
    bits = sum(9 * (2 + 1 + n) + 2 * 2 for n in reads)
    assert busy_ns == pytest.approx(bits * 1e9 / bit_rate, abs=len(reads))
    assert count == sum(reads)


def test_a_request_a_break_and_the_reply_that_it_expects_take_their_time_on_a_serial_line() -> None:
    transfer = SerialTransfer((Break(0.001), b"\x01\x54"), exactly(2), 100 * MS)
    busy_ns, reply = bus_time(spoken(transfer), SerialTransfer(()), 9600)
    assert busy_ns == pytest.approx(1 * MS + 4 * 11e9 / 9600, abs=2)
    assert reply == bytes(2)


def test_a_course_without_end_is_left() -> None:
    busy_ns, left = bus_time(course_of(*[1] * 1000), IDLE, 100_000)
    assert (busy_ns, left) == (0, None)


def test_a_ranger_fires_again_when_it_has_answered_and_rested() -> None:
    assert PACE.period_ns == 58 * MS
    assert replace(PACE, rest_ns=10 * MS).period_ns == 23 * MS


def test_one_that_answers_the_command_itself_holds_its_bus_until_then() -> None:
    assert PACE.held_ns == 1 * MS
    assert replace(PACE, holds_bus=True).held_ns == 21 * MS


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
