from random import Random

import pytest
from hypothesis import given
from hypothesis.strategies import binary

from echogrid.emulation.devices.urm37 import Urm37Options, Urm37Sensor

from .line_host import MS, Host, room

DISTANCE = bytes.fromhex("22000022")


def sensor(*distances: float, speed: float = 343.21, **options: float) -> Urm37Sensor:
    chosen = Urm37Options(**options)  # type: ignore[arg-type]
    return Urm37Sensor("front", room(*distances, speed=speed), Random(1), chosen)


def test_the_data_sheet_s_request_is_answered_with_the_distance_when_it_has_ranged() -> None:
    host = Host(sensor(3.0))
    assert host.ask(DISTANCE, within_ns=50 * MS) == b""
    assert host.wait(50 * MS) == bytes.fromhex("22012C4F")


def test_nothing_heard_is_ff_ff() -> None:
    assert Host(sensor()).ask(DISTANCE, within_ns=100 * MS) == bytes.fromhex("22FFFF20")
    assert Host(sensor(8.1)).ask(DISTANCE, within_ns=100 * MS) == bytes.fromhex("22FFFF20")
    assert Host(sensor(no_echo=0)).ask(DISTANCE, within_ns=100 * MS) == bytes.fromhex("22000022")


def test_the_unit_is_an_option() -> None:
    assert Host(sensor(3.0, unit_mm=1.0)).ask(DISTANCE, within_ns=100 * MS) == bytes.fromhex("220BB8E5")


def test_too_near_reads_as_the_minimum() -> None:
    assert Host(sensor(0.005)).ask(DISTANCE, within_ns=100 * MS)[1:3] == b"\x00\x02"


@pytest.mark.parametrize(("speed", "reply"), [(343.21, "1100C8D9"), (325.19, "11FF9CAC")])
def test_the_temperature_is_the_air_s_in_tenths(speed: float, reply: str) -> None:
    assert Host(sensor(speed=speed)).ask(bytes.fromhex("11000011")) == bytes.fromhex(reply)


def test_a_request_with_a_wrong_sum_is_none_and_the_next_is_understood() -> None:
    host = Host(sensor(3.0))
    assert host.ask(bytes.fromhex("22000023"), within_ns=100 * MS) == b""
    assert host.ask(DISTANCE, within_ns=100 * MS) == bytes.fromhex("22012C4F")


@given(binary(max_size=12))
def test_whatever_came_before_a_pause_sets_it_in_step_again(noise: bytes) -> None:
    host = Host(sensor(3.0))
    host.ask(noise, within_ns=100 * MS)
    assert host.ask(DISTANCE, within_ns=100 * MS) == bytes.fromhex("22012C4F")


def test_while_it_ranges_it_takes_no_request() -> None:
    host = Host(sensor(3.0))
    host.ask(DISTANCE, within_ns=20 * MS)
    assert host.ask(DISTANCE, within_ns=200 * MS) == bytes.fromhex("22012C4F")


def test_each_request_is_a_ping() -> None:
    pings: list[int] = []
    host = Host(Urm37Sensor("front", room(1.0, pings=pings), Random(1)))
    host.ask(DISTANCE, within_ns=100 * MS)
    host.ask(bytes.fromhex("11000011"))
    assert len(pings) == 1


def test_garbage_and_delay_are_its_faults_and_an_address_it_has_not() -> None:
    device = sensor(3.0)
    host = Host(device)
    device.fault("garbage", 0)
    assert bytes.fromhex("22012C4F") not in [host.ask(DISTANCE, within_ns=100 * MS) for _ in range(8)]
    device.clear(host.now_ns)
    device.fault("delayed", host.now_ns)
    assert host.ask(DISTANCE, within_ns=250 * MS) == b""
    assert host.wait(20 * MS) == bytes.fromhex("22012C4F")
    assert "address_conflict" not in device.faults.verbs
