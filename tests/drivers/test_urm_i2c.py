from dataclasses import dataclass
from errno import ENXIO
from itertools import pairwise
from math import isnan

from hypothesis import given
from hypothesis.strategies import binary, floats, integers, lists, one_of, sampled_from
from pytest import approx, fixture, mark, raises

from echogrid.drivers.bus import I2cMessage, I2cResult, I2cTransfer
from echogrid.drivers.commanded import CommandedRanger
from echogrid.drivers.device import State
from echogrid.drivers.readings import Outcome
from echogrid.drivers.role import RangerRole, Slot
from echogrid.drivers.urm_i2c import URM09, URM13, Model, Urm09, Urm13I2c, address_change

from .i2c_bench import MS, SPEED, TRANSFER_NS
from .mute_bench import MuteBench, role

VERSION = 0x10
TEMPERATURE = b"\x00\xd7"
"""21.5 degrees Celsius."""
AFTER_THE_SET_UP = Slot(300 * MS, 230 * MS)


@dataclass(frozen=True, slots=True)
class Kind:
    """One of the two makes, and what it is set to for a reach of 3 m."""

    driver: type[Urm09 | Urm13I2c]
    model: Model
    address: int
    between: bytes
    """The registers from the temperature to the configuration."""
    configuration: int
    other: int
    """A configuration which is not that one."""

    def device(self, role: RangerRole) -> CommandedRanger[I2cTransfer]:
        if self.driver is Urm09:
            return Urm09(role, Urm09.Settings())
        return Urm13I2c(role, Urm13I2c.Settings())

    def registers(self, centimetres: int, configuration: int | None = None) -> bytes:
        """All up to the configuration."""
        chosen = self.configuration if configuration is None else configuration
        head = bytes((self.address, self.model.product, VERSION)) + centimetres.to_bytes(2, "big")
        return head + self.between + bytes((chosen,))


URM09_KIND = Kind(Urm09, URM09, 0x11, TEMPERATURE, 0x10, 0xA0)
URM13_KIND = Kind(Urm13I2c, URM13, 0x12, TEMPERATURE + b"\0\0", 0x04, 0x10)


class UrmBench(MuteBench):
    """Keeps its configuration as it is written, unless it is stubborn."""

    def __init__(self, kind: Kind, configuration: int | None = None, role: RangerRole | None = None) -> None:
        device = kind.device(role or role_to(3.0))
        fires = bytes((kind.model.command, 0x01))
        super().__init__(device, kind.registers(150, configuration), fires)
        self.kind = kind
        self.stubborn = False

    def result(self, transfer: I2cTransfer) -> I2cResult:
        result = super().result(transfer)
        data = transfer.messages[0].write
        is_set = data[:1] == bytes((self.kind.model.configuration,)) and len(data) == 2
        if is_set and not result.errno and not self.stubborn:
            self.registers = self.registers[:-1] + data[1:]
        return result

    @property
    def configured(self) -> list[int]:
        """What was written into the register of the configuration."""
        return [data[1] for data in self.written if data[0] == self.kind.model.configuration]


def role_to(farthest: float, slot: Slot = AFTER_THE_SET_UP) -> RangerRole:
    return role(0.05, farthest, slot)


@fixture(params=[URM09_KIND, URM13_KIND], ids=["urm09", "urm13-i2c"])
def kind(request: object) -> Kind:
    chosen: Kind = request.param  # type: ignore[attr-defined]  # pytest hands it over untyped
    return chosen


def test_the_golden_bytes_of_each(kind: Kind) -> None:
    urm = UrmBench(kind, kind.other)
    urm.run(400 * MS)
    count = kind.model.configuration + 1
    look = [I2cMessage(kind.address, write=b"\x00"), I2cMessage(kind.address, read=count)]
    configure = I2cMessage(kind.address, write=bytes((kind.model.configuration, kind.configuration)))
    ping = I2cMessage(kind.address, write=bytes((kind.model.command, 0x01)))
    assert [each.messages[0] for each in urm.transfers] == [*look, configure, *look, ping, *look]


def test_golden_readings() -> None:
    for kind, text in (
        (URM09_KIND, "11 01 10 01 2C 00 D7 20"),
        (URM13_KIND, "12 02 10 01 2C 00 D7 00 00 04"),
    ):
        urm = UrmBench(kind, role=role_to(5.0))
        urm.registers = bytes.fromhex(text)
        urm.run(400 * MS)
        assert [(reading.distance, reading.raw) for reading in urm.ranged()] == [(3.0, bytes.fromhex(text))]


def test_a_new_address_is_written_into_the_first_register() -> None:
    assert address_change(0x22) == bytes.fromhex("00 22")
    with raises(ValueError, match=r"address is 0x78: expected 0x08 to 0x77"):
        address_change(0x78)


@given(floats(0.1, 5.0))
def test_the_urm09_is_set_to_the_shortest_range_that_reaches(farthest: float) -> None:
    span = URM09.span(farthest)
    assert span.farthest >= farthest
    assert all(other.farthest < farthest for other in URM09.spans if other.farthest < span.farthest)


@mark.parametrize(
    ("model", "farthest", "configuration"),
    [
        *((URM09, 1.5, 0x00), (URM09, 1.6, 0x10), (URM09, 3.0, 0x10), (URM09, 5.0, 0x20)),
        *((URM13, 1.5, 0x14), (URM13, 1.6, 0x04), (URM13, 9.0, 0x04)),
    ],
)
def test_the_reach_chooses_the_range(model: Model, farthest: float, configuration: int) -> None:
    assert model.span(farthest).configuration == configuration


def test_a_reach_beyond_the_longest_range_is_refused() -> None:
    with raises(ValueError, match=r"max_m is 6.0: expected 0.0 to 5.0"):
        Urm09(role_to(6.0), Urm09.Settings())
    with raises(ValueError, match=r"max_m is 10.0: expected 0.0 to 9.0"):
        Urm13I2c(role_to(10.0), Urm13I2c.Settings())


def test_a_configuration_that_is_right_already_is_not_written(kind: Kind) -> None:
    urm = UrmBench(kind)
    urm.run(1000 * MS)
    assert urm.configured == []
    assert urm.state is State.WELL


def test_one_that_ranges_by_itself_is_told_to_wait_for_commands_and_left_100_ms(kind: Kind) -> None:
    urm = UrmBench(kind, kind.other, role_to(3.0, Slot(10 * MS, 0)))
    urm.run(100 * MS)
    assert urm.configured == [kind.configuration]
    assert urm.fired_ns == []
    urm.run(20 * MS)
    assert len(urm.fired_ns) == 1


def test_one_that_keeps_its_configuration_is_faulty(kind: Kind) -> None:
    urm = UrmBench(kind, kind.other)
    urm.stubborn = True
    urm.run(1000 * MS)
    assert urm.state is State.FAULTY
    assert "keeps its configuration" in urm.device.health(urm.now_ns).message
    assert urm.fired_ns == []


def test_another_product_is_the_wrong_device(kind: Kind) -> None:
    urm = UrmBench(kind)
    urm.registers = bytes((kind.address, 0x09)) + urm.registers[2:]
    urm.run(1000 * MS)
    assert urm.state is State.WRONG_DEVICE
    wanted = f"not product {kind.model.product:#04x}, a {kind.model.name}"
    assert f"product 0x09 version 0x10, {wanted}" in urm.device.health(urm.now_ns).message
    assert urm.configured == []


@mark.parametrize(("product", "version"), [(0x00, VERSION), (0x00, 0x00), (None, 0x00)])
def test_ones_missing_in_its_identity_are_a_conflict(kind: Kind, product: int | None, version: int) -> None:
    urm = UrmBench(kind)
    said = kind.model.product if product is None else product
    urm.registers = bytes((kind.address, said, version)) + urm.registers[3:]
    urm.run(1000 * MS)
    assert urm.state is State.CONFLICT
    assert "two devices at one address?" in urm.device.health(urm.now_ns).message
    assert urm.fired_ns == []


@mark.parametrize(
    ("centimetres", "outcome", "reached"),
    [
        (150, Outcome.ECHO, 1.5),
        (0xFFFF, Outcome.NO_ECHO, 3.0),
        (300, Outcome.NO_ECHO, 3.0),
        (4, Outcome.TOO_CLOSE, 0.04),
        (0, Outcome.INVALID, 3.0),
        (2000, Outcome.INVALID, 3.0),
    ],
)
def test_every_result_has_its_meaning_and_its_moment(
    kind: Kind, centimetres: int, outcome: Outcome, reached: float
) -> None:
    urm = UrmBench(kind)
    urm.registers = kind.registers(centimetres)
    urm.run(400 * MS)
    (reading,) = urm.ranged()
    assert reading.outcome is outcome
    assert reading.distance == approx(reached) if outcome is Outcome.ECHO else isnan(reading.distance)
    assert reading.stamp_ns == approx(230 * MS + TRANSFER_NS // 2 + reached / SPEED * 1e9, abs=1)
    assert bool(reading.reason) == (outcome is Outcome.INVALID)


def test_the_urm13_is_blind_to_40_cm_where_it_reaches_far() -> None:
    urm = UrmBench(URM13_KIND)
    urm.registers = URM13_KIND.registers(39)
    urm.run(400 * MS)
    assert [reading.outcome for reading in urm.ranged()] == [Outcome.TOO_CLOSE]


def test_another_value_for_nothing_can_be_set() -> None:
    device = Urm13I2c(role_to(3.0), Urm13I2c.Settings(no_echo_cm=(0, 0xFFFF)))
    each = MuteBench(device, URM13_KIND.registers(0), b"\x0a\x01")
    each.run(400 * MS)
    assert [reading.outcome for reading in each.ranged()] == [Outcome.NO_ECHO]


def test_it_reads_100_ms_after_it_fired_and_not_before(kind: Kind) -> None:
    urm = UrmBench(kind)
    urm.run(329 * MS)
    assert (urm.fired_ns, urm.readings) == ([230 * MS], [])
    urm.run(5 * MS)
    assert len(urm.readings) == 1


@given(integers(1, 400), integers(0, 400))
def test_it_never_fires_again_within_98_ms(period_ms: int, offset_ms: int) -> None:
    urm = UrmBench(URM09_KIND, role=role_to(3.0, Slot(period_ms * MS, offset_ms * MS)))
    urm.run(1500 * MS)
    assert all(b - a >= 98 * MS for a, b in pairwise(urm.fired_ns))


def test_another_identity_in_an_answer_is_a_conflict(kind: Kind) -> None:
    urm = UrmBench(kind)
    urm.run(250 * MS)
    urm.registers = bytes((kind.address, 0x00, VERSION)) + urm.registers[3:]
    urm.run(82 * MS)
    (reading,) = urm.ranged()
    was = f"{kind.address:02x}{kind.model.product:02x}10"
    wanted = f"address, product and version {kind.address:02x}0010 were {was} at the set-up"
    assert (reading.outcome, reading.reason) == (
        Outcome.INVALID,
        f"{wanted}: two devices at one address?",
    )


def test_a_configuration_lost_with_the_power_is_written_again(kind: Kind) -> None:
    urm = UrmBench(kind)
    urm.run(250 * MS)
    urm.registers = kind.registers(150, kind.other)
    urm.run(400 * MS)
    first, second = urm.ranged()
    assert (first.outcome, second.outcome) == (Outcome.INVALID, Outcome.ECHO)
    assert first.reason == f"its configuration {kind.other:#04x} is not the one set: did it restart?"
    assert urm.configured == [kind.configuration]
    assert urm.state is State.WELL


def test_a_missing_one_is_named_with_its_address_and_found_again(kind: Kind) -> None:
    urm = UrmBench(kind)
    urm.errno = ENXIO
    urm.run(1000 * MS)
    assert urm.state is State.MISSING
    assert f"{kind.address:#04x} (7 bit)" in urm.device.health(urm.now_ns).message
    urm.errno = 0
    urm.run(2500 * MS)
    assert urm.state is State.WELL


def test_a_bus_that_reads_ones_without_an_acknowledge_is_an_empty_one(kind: Kind) -> None:
    urm = UrmBench(kind)
    urm.registers = b"\xff" * 10
    urm.run(1000 * MS)
    assert urm.state is State.MISSING


@mark.parametrize(
    ("key", "value", "allowed"), [("address", 0x07, "0x08 to 0x77"), ("no_echo_cm", (70_000,), "0 to 65535")]
)
def test_impossible_settings_are_refused_by_name(key: str, value: object, allowed: str) -> None:
    for settings in (Urm09.Settings, Urm13I2c.Settings):
        with raises(ValueError, match=rf"{key} is \w+: expected {allowed}"):
            settings(**{key: value})


@given(
    lists(
        one_of(
            binary(min_size=8, max_size=8),
            sampled_from([URM09_KIND.registers(each) for each in (0, 2, 150, 299, 300, 0xFFFF)]),
            binary(min_size=2, max_size=2).map(lambda each: b"\x11\x01\x10" + each + b"\0\xd7\x10"),
        ),
        max_size=20,
    )
)
def test_whatever_it_says_each_ping_gives_one_possible_reading(answers: list[bytes]) -> None:
    urm = UrmBench(URM09_KIND)
    for answer in answers:
        urm.registers = answer
        urm.run(300 * MS)
    urm.errno = ENXIO
    urm.run(500 * MS)
    assert len(urm.readings) == len(urm.fired_ns)
    for reading in urm.ranged():
        assert (reading.outcome is Outcome.ECHO) == (0.05 <= reading.distance < 3.0)
