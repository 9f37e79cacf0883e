from random import Random

import pytest

from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.devices.urm_modbus import (
    Urm12Options,
    Urm12Sensor,
    Urm13Options,
    Urm13Sensor,
    Urm14Options,
    Urm14Sensor,
    Urm15Options,
    Urm15Sensor,
    UrmSensor,
)
from echogrid.emulation.errors import RobotSpecError
from echogrid.emulation.models import RANGERS
from echogrid.emulation.scene import Echo

from .modbus_host import MS, Host

WARM, COLD = 343.21, 331.3
"""m/s at 20 and at 0 degrees Celsius."""
MODELS = {
    "urm12": (Urm12Sensor, Urm12Options),
    "urm13": (Urm13Sensor, Urm13Options),
    "urm14": (Urm14Sensor, Urm14Options),
    "urm15": (Urm15Sensor, Urm15Options),
}
LONG = 2000 * MS


def sensor(
    model: str = "urm14", distance: float | None = 1.2345, speed: float = WARM, **options: object
) -> UrmSensor:
    echoes = () if distance is None else (Echo(distance, 40.0, "wall"),)
    kind, kinds_options = MODELS[model]
    surroundings = Surroundings(lambda fire_ns: echoes, speed)
    return kind("front", surroundings, Random(1), kinds_options(**options))


def ranged(host: Host, address: int, control: int = 4) -> int:
    """The distance register after a ping."""
    host.write(address, 8, control | 8)
    host.wait(LONG)
    return host.read(address, 5)[0]


def test_the_distance_is_read_with_the_bytes_of_the_data_sheet() -> None:
    host = Host(sensor())
    host.say("0C 06 00 08 00 0C 09 10")
    assert host.say("0C 03 00 05 00 01 95 16") == bytes.fromhex("0C 03 02 30 39 41 97")


def test_before_its_first_ping_it_has_no_distance() -> None:
    assert Host(sensor()).say("0C 03 00 05 00 01 95 16") == bytes.fromhex("0C 03 02 FF FF 94 35")


@pytest.mark.parametrize(
    ("model", "address", "product", "counts", "nothing"),
    [
        ("urm12", 0x0B, 1, 123, 0),
        ("urm13", 0x0D, 3, 123, 0xFFFF),
        ("urm14", 0x0C, 2, 12_345, 0xFFFF),
        ("urm15", 0x0F, 5, 1234, 0xFFFF),
    ],
)
def test_each_model_has_its_address_product_unit_and_word_for_nothing(
    model: str, address: int, product: int, counts: int, nothing: int
) -> None:
    host = Host(sensor(model))
    assert host.read(address, 0, 9) == [product, 0x10, address, 5, 1, nothing, 200, 0, 4]
    assert ranged(host, address) == counts
    nobody = Host(sensor(model, None))
    assert ranged(nobody, address) == nothing


def test_a_urm13_may_count_millimetres() -> None:
    assert ranged(Host(sensor("urm13", unit_mm=1.0)), 0x0D) == 1234


def test_a_read_only_register_can_t_be_written_and_there_is_no_tenth() -> None:
    host = Host(sensor())
    assert {bytes(host.write(12, register, 1)) for register in (0, 1, 5, 6, 9)} == {bytes((0x86, 2))}
    assert host.ask(12, 3, 0, 5, 0, 5) == bytes((0x83, 2))


@pytest.mark.parametrize(
    ("model", "address", "control", "lasts_ms"),
    [
        ("urm12", 0x0B, 4, 333),
        ("urm13", 0x0D, 4, 100),
        ("urm13", 0x0D, 0x14, 20),
        ("urm14", 0x0C, 4, 33),
        ("urm15", 0x0F, 4, 100),
    ],
)
def test_until_a_ping_is_over_its_bit_stands_and_the_distance_is_the_one_before(
    model: str, address: int, control: int, lasts_ms: int
) -> None:
    pings: list[int] = []
    kind, kinds_options = MODELS[model]
    surroundings = Surroundings(lambda fire_ns: (Echo(1.0, 40.0, "wall"),), WARM, ping=pings.append)
    host = Host(kind("front", surroundings, Random(1), kinds_options()))
    host.ask(address, 6, 0, 8, 0, control | 8, for_ns=15 * MS)
    before = host.read(address, 5, 4, for_ns=15 * MS)
    assert before[0] in (0, 0xFFFF)
    assert before[3] == control | 8
    host.wait(max(pings[0] + lasts_ms * MS - host.now_ns, 5 * MS))
    after = host.read(address, 5, 4)
    assert after[0] in (100, 1000, 10_000)
    assert after[3] == control


def test_some_firmware_leaves_the_bit_as_it_was_written() -> None:
    host = Host(sensor(clears_trigger=0))
    assert ranged(host, 12) == 12_345
    assert host.read(12, 8) == [12]


def test_a_command_while_it_pings_is_passed_over() -> None:
    fired: list[int] = []

    def scene(fire_ns: int) -> tuple[Echo, ...]:
        fired.append(fire_ns)
        return ()

    host = Host(Urm12Sensor("front", Surroundings(scene, WARM), Random(1), Urm12Options()))
    host.write(0x0B, 8, 12)
    host.write(0x0B, 8, 12)
    host.wait(LONG)
    assert len(fired) == 1


def test_in_its_short_range_a_urm13_hears_nothing_far() -> None:
    host = Host(sensor("urm13", 2.0))
    assert ranged(host, 0x0D, 4) == 200
    assert ranged(host, 0x0D, 0x14) == 0xFFFF


def test_without_the_passive_bit_it_pings_by_itself_again_and_again() -> None:
    pings: list[int] = []
    surroundings = Surroundings(lambda fire_ns: (), WARM, ping=pings.append)
    host = Host(Urm15Sensor("front", surroundings, Random(1), Urm15Options(control=0)))
    host.wait(1000 * MS)
    assert len(pings) in (10, 11)
    host.write(0x0F, 8, 4)
    host.wait(LONG)
    before = len(pings)
    host.wait(LONG)
    assert len(pings) == before


def test_its_distance_is_true_at_any_temperature_and_it_tells_which() -> None:
    host = Host(sensor(speed=COLD))
    assert ranged(host, 12) == 12_345
    assert host.read(12, 6) == [0]
    assert Host(sensor(speed=320.0)).read(12, 6)[0] > 0x8000


def test_uncorrected_it_reckons_with_20_degrees() -> None:
    host = Host(sensor(speed=COLD))
    assert ranged(host, 12, 6) == round(12_345 * WARM / COLD)


def test_told_a_temperature_it_reckons_with_that() -> None:
    host = Host(sensor(speed=COLD))
    host.write(12, 7, (-100) & 0xFFFF)
    assert ranged(host, 12, 5) == pytest.approx(12_345 * 325.18 / COLD, abs=2)
    assert host.read(12, 7) == [0xFF9C]


def test_a_new_address_counts_from_the_next_power_up_on() -> None:
    device = sensor()
    host = Host(device)
    assert host.write(12, 2, 0x21) == bytes.fromhex("06 00 02 00 21")
    assert host.read(12, 2) == [0x21]
    device.fault("off", host.now_ns, 100 * MS)
    host.wait(200 * MS)
    assert host.ask(12, 3, 0, 2, 0, 1) == b""
    assert host.read(0x21, 2) == [0x21]


@pytest.mark.parametrize("address", [0, 248, 0x1234])
def test_an_impossible_address_is_refused(address: int) -> None:
    assert Host(sensor()).write(12, 2, address) == bytes((0x86, 3))


def test_an_address_may_be_given_to_all() -> None:
    device = sensor()
    host = Host(device)
    assert host.write(0, 2, 0x21) == b""
    device.fault("off", host.now_ns, 100 * MS)
    host.wait(200 * MS)
    assert host.read(0x21, 0) == [2]


def test_without_power_it_keeps_its_mode_but_not_its_distance() -> None:
    device = sensor()
    host = Host(device)
    ranged(host, 12, 6)
    device.fault("off", host.now_ns, 100 * MS)
    host.wait(200 * MS)
    assert host.read(12, 5, 4) == [0xFFFF, 200, 0, 6]


def test_a_slow_one_takes_five_times_as_long() -> None:
    device = sensor()
    host = Host(device)
    device.fault("slow", host.now_ns)
    host.write(12, 8, 12)
    assert host.read(12, 5) == [0xFFFF]
    host.wait(100 * MS)
    assert host.read(12, 5) == [12_345]


def test_a_wrong_one_is_wrong_by_half() -> None:
    device = sensor(distance=0.5)
    host = Host(device)
    device.fault("wrong", host.now_ns)
    assert ranged(host, 12) == 7500


def test_a_stuck_one_tells_the_same_for_ever() -> None:
    distance = [1.0]
    surroundings = Surroundings(lambda fire_ns: (Echo(distance[0], 40.0, "wall"),), WARM)
    device = Urm14Sensor("front", surroundings, Random(1), Urm14Options())
    host = Host(device)
    assert ranged(host, 12) == 10_000
    device.fault("stuck", host.now_ns)
    distance[0] = 0.5
    assert ranged(host, 12) == 10_000


def test_a_baud_that_it_can_t_speak_is_refused() -> None:
    with pytest.raises(ValueError, match="baud 12345 is none of 2400, 9600, 14400"):
        Urm14Options(baud=12_345)


@pytest.mark.parametrize("model", MODELS)
def test_models_are_built_with_the_settings_that_they_share_with_their_drivers(model: str) -> None:
    surroundings = Surroundings(lambda fire_ns: (), WARM)
    shared = {"address": 99, "baud": 9600, "parity": "even", "stop_bits": 2, "echo": 1, "clears_trigger": 0}
    device = RANGERS[model].build("front", surroundings, Random(1), shared)
    assert isinstance(device, UrmSensor)
    assert (device.address, device.baud, device.bits_per_byte, device.one_wire) == (99, 9600, 12, True)
    with pytest.raises(RobotSpecError, match="front: address 300"):
        RANGERS[model].build("front", surroundings, Random(1), {"address": 300})
