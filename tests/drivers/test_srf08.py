from errno import ENXIO, EREMOTEIO
from itertools import pairwise
from math import isnan

from hypothesis import given
from hypothesis.strategies import binary, floats, integers, lists, one_of, sampled_from
from pytest import approx, mark, raises

from echogrid.drivers.bus import I2cMessage, I2cResult, I2cTransfer
from echogrid.drivers.device import Level, Line
from echogrid.drivers.readings import Outcome, RangeReading, Reading
from echogrid.drivers.role import RangerRole, Slot
from echogrid.drivers.srf08 import PATIENCE_NS, Srf08, echoes_us, gate_us, range_register, ready

MS = 1_000_000
SPEED = 343.0
SLOT = Slot(200 * MS, 30 * MS)
ROLE = RangerRole("left", 0.05, 3.0, SLOT, SPEED)
TRANSFER_NS = 300_000
BUSY = b"\xff\xff\xff\xff"


def echo(microseconds: int) -> bytes:
    return bytes([9, 80]) + microseconds.to_bytes(2, "big")


class Bench:
    """A chip played by hand: it acknowledges, fires, and answers what `registers` says."""

    def __init__(self, role: RangerRole = ROLE, settings: Srf08.Settings | None = None) -> None:
        self.device = Srf08(role, settings or Srf08.Settings())
        self.now_ns = 0
        self.registers = echo(0)
        self.errno = 0
        self.ping_ns = 0
        self.written: list[bytes] = []
        self.fired_ns: list[int] = []
        self.readings: list[Reading] = []
        self.reads = 0

    def run(self, for_ns: int) -> None:
        """Let the device do what it wants until so much time is over."""
        end_ns = self.now_ns + for_ns
        received: list[I2cResult] = []
        while True:
            step = self.device.step(self.now_ns, received)
            self.readings += step.readings
            received = [self.result(transfer) for transfer in step.send]
            if not received:
                if step.deadline_ns > end_ns:
                    break
                self.now_ns = max(self.now_ns, step.deadline_ns)
        self.now_ns = end_ns

    def result(self, transfer: I2cTransfer) -> I2cResult:
        (message,) = transfer.messages
        start_ns = self.now_ns
        self.now_ns += TRANSFER_NS
        if self.errno:
            return I2cResult(transfer, start_ns, self.now_ns, errno=self.errno)
        if message.read:
            self.reads += 1
            busy = bool(self.fired_ns) and self.now_ns < self.fired_ns[-1] + self.ping_ns
            return I2cResult(
                transfer, start_ns, self.now_ns, (BUSY if busy else self.registers)[: message.read]
            )
        self.written.append(message.write)
        if message.write == b"\x00\x52":
            self.fired_ns.append(start_ns)
        return I2cResult(transfer, start_ns, self.now_ns)

    def ranged(self) -> list[RangeReading]:
        return [reading for reading in self.readings if isinstance(reading, RangeReading)]


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
    with raises(ValueError, match=r"farthest is 12.0: expected 0.0 to 11.01"):
        Srf08(RangerRole("left", 0.05, 12.0, SLOT, SPEED), Srf08.Settings())


@mark.parametrize(
    ("key", "value", "allowed"),
    [("address", 0x6F, "112 to 127"), ("gain", 32, "0 to 31"), ("gain", -1, "0 to 31")],
)
def test_impossible_settings_are_refused_by_name(key: str, value: int, allowed: str) -> None:
    with raises(ValueError, match=f"{key} is {value}: expected {allowed}"):
        Srf08.Settings(**{key: value})


def test_registers_are_decoded() -> None:
    assert echoes_us(bytes.fromhex("09 80 44 5C")) == (17500,)
    assert ready(bytes.fromhex("09 80 44 5C"))
    assert not ready(BUSY)
    assert not ready(bytes(4))


def test_it_is_set_up_with_gain_and_range_before_it_fires() -> None:
    bench = Bench(settings=Srf08.Settings(gain=7))
    bench.run(60 * MS)
    assert bench.written[:4] == [b"\x00", b"\x01\x07", b"\x02\x45", b"\x00\x52"]


def test_pointer_and_read_are_separate_transfers() -> None:
    device = Srf08(ROLE, Srf08.Settings(address=0x71))
    (pointer,) = device.step(0, []).send
    (read,) = device.step(1, [I2cResult(pointer, 0, 1)]).send
    assert pointer.messages == (I2cMessage(0x71, write=b"\x00"),)
    assert read.messages == (I2cMessage(0x71, read=4),)


def test_it_fires_in_its_slot() -> None:
    bench = Bench()
    bench.run(1000 * MS)
    assert bench.fired_ns == [30 * MS, 230 * MS, 430 * MS, 630 * MS, 830 * MS]


@given(integers(1, 400), integers(0, 400), floats(0.3, 6.0))
def test_it_never_fires_again_within_58_ms(period_ms: int, offset_ms: int, farthest: float) -> None:
    bench = Bench(RangerRole("left", 0.05, farthest, Slot(period_ms * MS, offset_ms * MS), SPEED))
    bench.run(1000 * MS)
    assert all(b - a >= 58 * MS for a, b in pairwise(bench.fired_ns))


def test_without_a_slot_it_fires_as_often_as_it_may() -> None:
    bench = Bench(RangerRole("left", 0.05, 3.0, None, SPEED))
    bench.run(1000 * MS)
    assert len(bench.fired_ns) > 10


def test_a_slot_that_comes_late_is_left_to_the_neighbours() -> None:
    bench = Bench()
    bench.run(20 * MS)
    bench.now_ns = 60 * MS
    bench.run(100 * MS)
    assert bench.fired_ns == []
    assert bench.device.health(0).counts["missed slots"] == 1


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
    bench = Bench()
    bench.registers = echo(microseconds)
    bench.run(100 * MS)
    (reading,) = bench.ranged()
    assert reading.outcome is outcome
    assert reading.distance == approx(reached) if outcome is Outcome.ECHO else isnan(reading.distance)
    assert reading.stamp_ns == 30 * MS + TRANSFER_NS // 2 + round(reached / SPEED * 1e9)
    assert reading.stamp_error_ns == TRANSFER_NS // 2 + 1000
    assert reading.raw == echo(microseconds)
    assert bool(reading.reason) == (outcome is Outcome.INVALID)


def test_a_result_under_another_revision_is_invalid() -> None:
    bench = Bench()
    bench.run(20 * MS)
    bench.registers = bytes([77]) + echo(10_000)[1:]
    bench.run(80 * MS)
    assert [reading.reason for reading in bench.ranged()] == [
        "revision 77 was 9 at the set-up: two devices at one address?"
    ]


def test_while_it_pings_it_is_polled_every_5_ms() -> None:
    bench = Bench()
    bench.ping_ns = 40 * MS
    bench.registers = echo(10_000)
    bench.run(100 * MS)
    assert [reading.outcome for reading in bench.ranged()] == [Outcome.ECHO]
    assert 3 <= bench.device.health(0).counts["busy"] <= 5


@mark.parametrize("errno", [ENXIO, EREMOTEIO])
def test_a_missing_acknowledge_while_it_pings_means_busy(errno: int) -> None:
    bench = Bench()
    bench.registers = echo(10_000)
    bench.run(40 * MS)
    bench.errno = errno
    bench.run(20 * MS)
    bench.errno = 0
    bench.run(20 * MS)
    assert [reading.outcome for reading in bench.ranged()] == [Outcome.ECHO]
    assert bench.device.health(bench.now_ns).level is Level.OK


def test_a_chip_that_never_gets_ready_gives_one_invalid_reading_and_is_set_up_again() -> None:
    bench = Bench()
    bench.ping_ns = 150 * MS
    bench.run(29 * MS)
    bench.run(200 * MS)
    (reading,) = bench.ranged()
    assert (reading.outcome, reading.reason) == (Outcome.INVALID, "not ready in time")
    bench.ping_ns = 0
    bench.run(400 * MS)
    assert bench.written.count(b"\x01\x1f") == 2
    assert bench.ranged()[-1].outcome is Outcome.NO_ECHO


def test_the_wait_for_a_chip_is_bounded() -> None:
    bench = Bench()
    bench.run(20 * MS)
    bench.ping_ns = 10_000 * MS
    bench.run(30 * MS + 20 * MS + PATIENCE_NS)
    assert len(bench.ranged()) == 1


def test_a_missing_chip_is_asked_for_ever_less_often_and_named_in_its_health() -> None:
    bench = Bench()
    bench.errno = EREMOTEIO
    bench.run(10_000 * MS)
    assert 5 <= bench.device.health(0).counts["missing"] <= 10
    assert bench.device.health(0).level is Level.ERROR
    assert "0x70 (7 bit)" in bench.device.health(0).message


def test_a_chip_that_comes_back_is_set_up_again() -> None:
    bench = Bench()
    bench.run(100 * MS)
    bench.errno = EREMOTEIO
    bench.run(1000 * MS)
    bench.errno = 0
    bench.written.clear()
    bench.run(2100 * MS)
    assert bench.written[:4] == [b"\x00", b"\x01\x1f", b"\x02\x45", b"\x00\x52"]
    assert bench.device.health(bench.now_ns).level is Level.OK


def test_a_ping_that_was_not_acknowledged_gives_no_reading() -> None:
    bench = Bench()
    bench.run(20 * MS)
    bench.errno = EREMOTEIO
    bench.run(20 * MS)
    assert bench.ranged() == []
    assert bench.device.health(0).counts["failed to fire"] == 1


def test_a_ping_under_way_when_the_port_is_lost_is_invalid() -> None:
    bench = Bench()
    bench.run(35 * MS)
    bench.device.lost(bench.now_ns)
    bench.run(100 * MS)
    assert [reading.reason for reading in bench.ranged()] == ["port lost"]
    assert bench.written.count(b"\x01\x1f") == 2


def test_losing_the_port_between_pings_gives_no_reading() -> None:
    bench = Bench()
    bench.run(20 * MS)
    bench.device.lost(bench.now_ns)
    bench.run(5 * MS)
    assert bench.ranged() == []


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
    bench = Bench()
    assert bench.device.health(0).level is Level.STALE
    bench.run(100 * MS)
    assert bench.device.health(100 * MS).level is Level.OK
    assert bench.device.health(5000 * MS).level is Level.STALE


def test_health_warns_of_an_invalid_reading() -> None:
    bench = Bench()
    bench.registers = echo(40_000)
    bench.run(55 * MS)
    assert "40000 us is longer than it listened" in bench.ranged()[0].reason
    assert bench.device.health(bench.now_ns).level is Level.WARN


@given(lists(one_of(binary(min_size=4, max_size=4), sampled_from([BUSY, echo(0), echo(9000)])), max_size=30))
def test_whatever_the_chip_says_each_ping_gives_one_possible_reading(answers: list[bytes]) -> None:
    bench = Bench()
    for answer in answers:
        bench.registers = answer
        bench.run(100 * MS)
    bench.registers = echo(0)
    bench.run(195 * MS)
    assert len(bench.fired_ns) - len(bench.readings) in (0, 1)
    for reading in bench.ranged():
        assert (reading.outcome is Outcome.ECHO) == (ROLE.nearest <= reading.distance < ROLE.farthest)
