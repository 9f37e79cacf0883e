from random import Random

import pytest
from hypothesis import given
from hypothesis.strategies import binary

from echogrid.emulation.devices.urm07 import Urm07Options, Urm07Sensor

from .line_host import MS, Host, room

DISTANCE = bytes.fromhex("55AA11000212")
"""The data sheet's own."""
TRIGGER = bytes.fromhex("55AA11000111")
TEMPERATURE = bytes.fromhex("55AA11000313")


def sensor(*distances: float, name: str = "front", speed: float = 343.21, **options: float) -> Urm07Sensor:
    chosen = Urm07Options(**options)  # type: ignore[arg-type]
    return Urm07Sensor(name, room(*distances, speed=speed), Random(1), chosen)


def test_the_data_sheet_s_request_is_answered_with_the_distance_when_it_has_ranged() -> None:
    host = Host(sensor(4.66, unit_mm=1.0))
    assert host.ask(DISTANCE, within_ns=53 * MS) == b""
    assert host.wait(50 * MS) == bytes.fromhex("55AA11020212345A")


def test_as_it_is_delivered_it_counts_centimetres() -> None:
    assert Host(sensor(3.0)).ask(DISTANCE, within_ns=100 * MS)[5:7] == b"\x01\x2c"


@pytest.mark.parametrize("distances", [(), (7.6,), (0.19,)])
def test_nothing_within_its_range_is_ff_ff(distances: tuple[float, ...]) -> None:
    assert Host(sensor(*distances)).ask(DISTANCE, within_ns=100 * MS) == bytes.fromhex("55AA110202FFFF12")


@pytest.mark.parametrize(("speed", "word"), [(343.21, "00C8"), (325.19, "FF9C")])
def test_the_temperature_is_the_air_s_in_tenths(speed: float, word: str) -> None:
    reply = Host(sensor(speed=speed)).ask(TEMPERATURE)
    assert reply[:5] + reply[5:7] == bytes.fromhex(f"55AA110203{word}")
    assert reply[-1] == sum(reply[:-1]) & 0xFF


def test_of_several_on_a_line_the_one_that_is_meant_answers() -> None:
    host = Host(sensor(1.0, name="a"), sensor(2.0, name="b", address=0x12))
    assert host.ask(bytes.fromhex("55AA12000213"), within_ns=100 * MS) == bytes.fromhex("55AA12020200C8DD")
    assert host.ask(bytes.fromhex("55AA13000214"), within_ns=100 * MS) == b""


def test_anybody_answers_at_ab_with_its_own_address() -> None:
    assert Host(sensor(3.0)).ask(bytes.fromhex("55AAAB0003AD"))[2] == 0x11


def test_one_that_is_triggered_ranges_then_and_tells_at_once_later() -> None:
    pings: list[int] = []
    options = Urm07Options(triggers=1, baud=115_200, ranging_ns=30 * MS, reach=5.0)
    host = Host(Urm07Sensor("front", room(3.0, pings=pings), Random(1), options))
    assert host.ask(DISTANCE)[5:7] == b"\xff\xff"
    assert host.ask(TRIGGER, within_ns=31 * MS) == b""
    assert host.ask(DISTANCE)[5:7] == b"\x01\x2c"
    assert len(pings) == 1


def test_one_that_is_not_knows_no_trigger() -> None:
    pings: list[int] = []
    host = Host(Urm07Sensor("front", room(3.0, pings=pings), Random(1)))
    assert (host.ask(TRIGGER, within_ns=100 * MS), pings) == (b"", [])


def test_it_moves_to_another_address_for_good() -> None:
    device = sensor(3.0)
    host = Host(device)
    assert host.ask(bytes.fromhex("55AA1101552379")) == b""
    assert host.ask(bytes.fromhex("55AA1101552389")) == bytes.fromhex("55AA230155CC44")
    device.fault("off", host.now_ns, MS)
    host.wait(10 * MS)
    assert (host.ask(TEMPERATURE), len(host.ask(bytes.fromhex("55AA23000325")))) == (b"", 8)


@given(binary(max_size=12))
def test_whatever_came_before_a_pause_it_is_in_step_again(noise: bytes) -> None:
    host = Host(sensor(3.0))
    host.ask(noise, within_ns=150 * MS)
    assert host.ask(DISTANCE, within_ns=100 * MS)[5:7] == b"\x01\x2c"


def test_a_head_in_the_middle_of_noise_is_found() -> None:
    assert (
        Host(sensor(3.0)).ask(b"\x55\x00\x55\xaa\x11\x77" + DISTANCE, within_ns=100 * MS)[5:7] == b"\x01\x2c"
    )


@pytest.mark.parametrize(
    ("options", "words"), [({"address": 0x10}, "0x11 to 0x80"), ({"baud": 0}, "must be above 0")]
)
def test_impossible_options_are_refused(options: dict[str, int], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        Urm07Options(**options)  # type: ignore[arg-type]


def test_two_at_one_address_spoil_each_other_s_sum() -> None:
    device = sensor(3.0)
    host = Host(device)
    device.fault("address_conflict", 0)
    replies = [host.ask(DISTANCE, within_ns=100 * MS) for _ in range(20)]
    assert not any(len(reply) == 8 and reply[-1] == sum(reply[:-1]) & 0xFF for reply in replies)
