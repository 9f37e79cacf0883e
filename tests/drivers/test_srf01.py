from errno import EIO, EPROTO, ETIMEDOUT
from random import Random

from hypothesis import given
from hypothesis.strategies import binary, lists, one_of, sampled_from
from pytest import approx, mark, raises

from echogrid.drivers.bus import Break, SerialTransfer
from echogrid.drivers.device import State
from echogrid.drivers.readings import Outcome
from echogrid.drivers.role import RangerRole, Slot
from echogrid.drivers.srf01 import Srf01, address_change
from echogrid.emulation.devices.srf01 import Srf01Options, Srf01Sensor

from .serial_bench import MS, SPEED, Bench, Joined, room

SLOT = Slot(200 * MS, 30 * MS)
ROLE = RangerRole("front", 0.0, 4.0, SLOT, SPEED)
LOW = Break(0.003)


def bench(ranges: list[bytes | int], statuses: list[bytes | int], **settings: float) -> Bench:
    """A ranger played by hand: these are its answers, the last of each kind for ever."""
    said: dict[int, list[bytes | int]] = {0x5E: list(ranges), 0x5F: list(statuses)}

    def reply(send: tuple[bytes | Break, ...], now_ns: int) -> bytes | int:
        low, request = send
        assert low == LOW
        assert isinstance(request, bytes)
        answers = said.get(request[1], [b""])
        return answers.pop(0) if len(answers) > 1 else answers[0]

    return Bench(Srf01(ROLE, Srf01.Settings(**settings)), reply)  # type: ignore[arg-type]


def test_it_is_looked_for_by_its_status_and_every_message_has_a_break_before_it() -> None:
    play = bench([b"\x01\x2c"], [b"\x03"])
    play.run(130 * MS)
    assert play.sent()[:5] == [b"\x01\x5f", b"\x01\x5f", b"\x01\x51", b"\x01\x5e", b"\x01\x5e"]
    assert {transfer.echoed for transfer in play.transfers} == {True}
    assert all(send[0] == LOW for _, send in play.asked)


def test_the_golden_300_cm() -> None:
    play = bench([b"\x01\x2c"], [b"\x03"])
    play.run(130 * MS)
    assert [reading.distance for reading in play.ranged()] == [approx(3.0)]


def test_centimetres_are_by_its_own_speed_of_sound() -> None:
    play = bench([b"\x01\x2c"], [b"\x03"], speed_of_sound_m_s=330.0)
    play.run(130 * MS)
    assert [reading.distance for reading in play.ranged()] == [approx(3.0 * SPEED / 330.0)]


@mark.parametrize(("status", "nearest_cm"), [(b"\x00", 18), (b"\x02", 18), (b"\x01", 12), (b"\x03", 1)])
def test_how_near_it_hears_follows_from_its_status(status: bytes, nearest_cm: int) -> None:
    for centimetres, outcome in ((nearest_cm, Outcome.ECHO), (nearest_cm - 1, Outcome.TOO_CLOSE)):
        play = bench([bytes((0, centimetres))], [status])
        play.run(190 * MS)
        expected = outcome if centimetres else Outcome.NO_ECHO
        assert [reading.outcome for reading in play.ranged()] == [expected]


def test_its_status_is_asked_for_until_it_is_locked() -> None:
    play = bench([b"\x00\x64"], [b"\x02"] * 4 + [b"\x03"])
    play.run(1_500 * MS)
    assert play.sent().count(b"\x01\x5f") == 2 + 2 + 2
    assert play.state is State.WELL


@mark.parametrize(
    ("errno", "state", "words"),
    [
        (ETIMEDOUT, State.MISSING, "no reply from address 1"),
        (EIO, State.MISSING, "joined to its one wire"),
        (EPROTO, State.GARBLED, "noise"),
    ],
)
def test_every_failure_at_the_set_up_has_its_state(errno: int, state: State, words: str) -> None:
    play = bench([b"\0\0"], [errno])
    play.run(100 * MS)
    assert (play.state, words in play.message) == (state, True)


def test_a_status_that_does_not_come_leaves_the_one_before() -> None:
    play = bench([b"\x00\x64"], [b"\x02", b"\x02", ETIMEDOUT])
    play.run(190 * MS)
    assert [reading.outcome for reading in play.ranged()] == [Outcome.ECHO]


def test_a_turn_that_only_listens_is_told_so() -> None:
    play = bench([b"\x00\x64"], [b"\x03"])
    role = RangerRole("front", 0.0, 4.0, Slot(200 * MS, 30 * MS, listens_every=1), SPEED)
    play.device = Srf01(role, Srf01.Settings())
    play.run(130 * MS)
    assert [reading.listened for reading in play.ranged()] == [True]
    assert b"\x01\x57" in play.sent()


@mark.parametrize(
    ("key", "value", "allowed"),
    [("address", 0, "1 to 16"), ("address", 17, "1 to 16"), ("speed_of_sound_m_s", 34.3, "300.0 to 400.0")],
)
def test_impossible_settings_are_refused_by_name(key: str, value: float, allowed: str) -> None:
    with raises(ValueError, match=f"{key} is {value}: expected {allowed}"):
        Srf01.Settings(**{key: value})  # type: ignore[arg-type]


def test_it_is_moved_by_four_messages_with_breaks() -> None:
    assert address_change(1, 16) == tuple(
        SerialTransfer((LOW, bytes((1, last))), echoed=True) for last in (0xA0, 0xAA, 0xA5, 0x10)
    )
    with raises(ValueError, match="address is 17: expected 1 to 16"):
        address_change(1, 17)


RANGES = one_of(binary(min_size=1, max_size=5), sampled_from([b"\x00\x64", ETIMEDOUT, EIO]))
STATUSES = one_of(binary(min_size=1, max_size=1), sampled_from([ETIMEDOUT, EPROTO]))


@given(lists(RANGES, min_size=1, max_size=9), lists(STATUSES, min_size=1, max_size=9))
def test_whatever_it_says_each_ping_gives_at_most_one_reading_and_echoes_are_possible(
    ranges: list[bytes | int], statuses: list[bytes | int]
) -> None:
    play = bench([*ranges, b"\x00\x64"], [*statuses, b"\x03"])
    play.run(8_000 * MS)
    readings = play.ranged()
    assert len(readings) <= play.sent().count(b"\x01\x51")
    for reading in readings:
        assert (reading.outcome is Outcome.ECHO) == (0.0 <= reading.distance < 4.0)
    play.run(40_000 * MS)
    assert play.state is State.WELL


# The same with the emulated ranger, on the clock that jumps.


def joined(count: int, distance: float = 1.0) -> tuple[Joined, list[Srf01Sensor]]:
    """So many on one wire, each before a wall of its own, 10 cm apart."""
    sensors = [
        Srf01Sensor(str(n), room(distance + n / 10), Random(n), Srf01Options(address=n + 1))
        for n in range(count)
    ]
    period_ns = max(count, 2) * 100 * MS
    devices = [
        Srf01(
            RangerRole(str(n), 0.0, 4.0, Slot(period_ns, n * 100 * MS), SPEED),
            Srf01.Settings(address=n + 1),
        )
        for n in range(count)
    ]
    return Joined(sensors, devices), sensors


@mark.parametrize("distance", [0.2, 1.0, 2.344, 3.9])
def test_it_sees_the_scene_to_half_a_centimetre(distance: float) -> None:
    line, _ = joined(1, distance)
    line.run(1_000 * MS)
    readings = line.run(2_000 * MS)
    assert len(readings) == 10
    assert [reading.distance for reading in readings] == approx([distance] * 10, abs=0.0051)


def test_an_object_near_by_is_seen_when_it_is_locked() -> None:
    line, _ = joined(1, 0.05)
    early = line.run(1_000 * MS)
    late = line.run(2_000 * MS)[5:]
    assert Outcome.ECHO not in {reading.outcome for reading in early}
    assert {round(reading.distance, 3) for reading in late} == {0.05}


def test_without_breaks_on_the_wire_it_works_as_well() -> None:
    line, _ = joined(2)
    line.bus.lose_breaks()
    line.run(1_000 * MS)
    assert {round(reading.distance, 2) for reading in line.run(1_000 * MS)} == {1.0, 1.1}


def test_sixteen_on_one_wire_see_each_its_own_wall() -> None:
    line, _ = joined(16)
    line.run(4_000 * MS)
    readings = line.run(16 * 100 * 3 * MS)
    assert 16 * 3 - 1 <= len(readings) <= 16 * 3 + 1
    for reading in readings:
        assert reading.distance == approx(1.0 + int(reading.sensor) / 10, abs=0.0051)


@mark.parametrize(
    ("verb", "state"),
    [
        ("off", State.MISSING),
        ("unplug", State.MISSING),
        ("garbage", State.GARBLED),
        ("slow", State.MISSING),
        ("delayed", State.MISSING),
        ("address_conflict", State.GARBLED),
        ("stuck", State.WELL),
        ("wrong", State.WELL),
    ],
)
def test_each_fault_has_its_state_and_the_others_go_on(verb: str, state: State) -> None:
    line, sensors = joined(3)
    line.run(3_000 * MS)
    sensors[1].fault(verb, line.clock.now_ns())
    line.run(3_000 * MS)
    readings = line.run(3_000 * MS)
    assert line.states() == [State.WELL, state, State.WELL]
    for n in ("0", "2"):
        own = [reading for reading in readings if reading.sensor == n]
        assert 9 <= len(own) <= 11
        assert [reading.distance for reading in own] == approx([1.0 + int(n) / 10] * len(own), abs=0.0051)
    sensors[1].clear(line.clock.now_ns())
    line.run(4_000 * MS)
    readings = line.run(1_200 * MS)
    assert line.states() == [State.WELL] * 3
    assert {round(reading.distance, 3) for reading in readings if reading.sensor == "1"} == {1.1}


def test_a_bad_contact_comes_and_goes_and_gives_no_wrong_reading() -> None:
    line, sensors = joined(2)
    sensors[0].fault("intermittent", line.clock.now_ns())
    own = [reading for reading in line.run(30_000 * MS) if reading.sensor == "0"]
    assert {reading.outcome for reading in own} >= {Outcome.ECHO, Outcome.INVALID}
    assert {round(reading.distance, 3) for reading in own if reading.outcome is Outcome.ECHO} == {1.0}
