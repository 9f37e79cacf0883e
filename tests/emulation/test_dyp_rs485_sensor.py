from random import Random

import pytest

from echogrid.emulation.devices.dyp_rs485 import DypRs485Options, DypRs485Sensor
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.scene import Echo

from .modbus_host import MS, Host

WARM, COLD = 343.21, 331.3
LONG = 1000 * MS


def sensor(distance: float | None = 1.953, speed: float = WARM, **options: object) -> DypRs485Sensor:
    echoes = () if distance is None else (Echo(distance, 40.0, "wall"),)
    surroundings = Surroundings(lambda fire_ns: echoes, speed)
    return DypRs485Sensor("rear", surroundings, Random(1), DypRs485Options(**options))


@pytest.mark.parametrize(
    ("request_", "answers_ms"), [("01 03 01 00 00 01 85 F6", 520), ("01 03 01 01 00 01 D4 36", 120)]
)
def test_it_measures_when_it_is_asked_and_answers_then(request_: str, answers_ms: int) -> None:
    host = Host(sensor())
    start_ns = host.now_ns
    assert host.say(request_, LONG) == bytes.fromhex("01 03 02 07 A1 7B CC")
    on_the_wire_ms = (8 + 3.5 + 7) * 10 / 9.6
    assert host.came_ns - start_ns == pytest.approx((answers_ms + on_the_wire_ms) * MS, abs=MS)


@pytest.mark.parametrize("register", [0x0100, 0x0101])
def test_it_fires_120_ms_before_it_answers(register: int) -> None:
    pings: list[int] = []
    surroundings = Surroundings(lambda fire_ns: (), WARM, ping=pings.append)
    host = Host(DypRs485Sensor("rear", surroundings, Random(1)))
    host.read(1, register, for_ns=LONG)
    (fired_ns,) = pings
    assert host.came_ns - fired_ns == pytest.approx(120 * MS + 7 * 10 / 9.6 * MS, abs=MS)


def test_its_temperature_costs_no_ping() -> None:
    pings: list[int] = []
    host = Host(DypRs485Sensor("rear", Surroundings(lambda ns: (), COLD, ping=pings.append), Random(1)))
    assert host.read(1, 0x0102) == [0]
    assert pings == []


@pytest.mark.parametrize("distance", [None, 4.6])
def test_nothing_within_reach_is_the_value_0(distance: float | None) -> None:
    assert Host(sensor(distance)).read(1, 0x0101, for_ns=LONG) == [0]


def test_what_it_says_of_nothing_is_configurable() -> None:
    assert Host(sensor(None, no_echo=0xFFFD)).read(1, 0x0101, for_ns=LONG) == [0xFFFD]
    assert Host(sensor(None, no_echo=-1)).ask(1, 3, 1, 1, 0, 1, for_ns=LONG) == b""


def test_its_distance_is_true_at_any_temperature() -> None:
    assert Host(sensor(speed=COLD)).read(1, 0x0101, for_ns=LONG) == [1953]


def test_all_three_registers_may_be_read_at_once() -> None:
    assert Host(sensor()).read(1, 0x0100, 3, for_ns=LONG) == [1953, 1953, 200]


def test_other_registers_are_refused_and_none_can_be_written() -> None:
    host = Host(sensor())
    assert host.ask(1, 3, 1, 1, 0, 3, for_ns=LONG) == bytes((0x83, 2))
    assert host.ask(1, 3, 2, 0, 0, 1) == bytes((0x83, 2))
    assert host.write(1, 0x0200, 5) == bytes((0x86, 2))


def test_a_slow_one_takes_five_times_as_long() -> None:
    device = sensor()
    host = Host(device)
    device.fault("slow", host.now_ns)
    assert host.ask(1, 3, 1, 1, 0, 1, for_ns=500 * MS) == b""
    assert host.wait(500 * MS) == bytes.fromhex("01 03 02 07 A1 7B CC")


def test_switched_off_while_it_measures_it_says_nothing_later() -> None:
    device = sensor()
    host = Host(device)
    host.ask(1, 3, 1, 1, 0, 1, for_ns=60 * MS)
    device.fault("off", host.now_ns, 20 * MS)
    assert host.wait(LONG) == b""
    assert host.read(1, 0x0101, for_ns=LONG) == [1953]
