from dataclasses import replace
from math import tau
from typing import Any

from hypothesis import given
from hypothesis import strategies as st
from pytest import approx, mark, raises

from echogrid.drivers.bus import NEVER_NS, CanFrame
from echogrid.drivers.cia402 import decode_motion
from echogrid.drivers.cia402_state import DriveState, drive_state
from echogrid.drivers.device import State
from echogrid.drivers.readings import WheelReading
from echogrid.drivers.role import WheelRole
from echogrid.drivers.throttle import Throttle

from .cia402_bench import (
    BOOT,
    FAULT,
    PER_TURN,
    PRE_OPERATIONAL,
    ROLE,
    Bench,
    emergency,
    heartbeat,
    motion,
    status,
)


def told(given: list[WheelReading]) -> list[tuple[int, bool]]:
    return [(round(reading.angle / tau * PER_TURN), reading.discontinuity) for reading in given]


def test_the_known_frame_is_a_position_and_a_velocity() -> None:
    assert decode_motion(bytes.fromhex("C01DFEFF15030000")) == (-123456, 789)
    (reading,) = Bench().ready().hear(CanFrame(0x182, bytes.fromhex("C01DFEFF15030000")))
    assert reading.angle == approx(-123456 / PER_TURN * tau)
    assert reading.rate == approx(789 / PER_TURN * tau)
    assert reading.raw == bytes.fromhex("C01DFEFF15030000")


@mark.parametrize(
    ("word", "state"),
    [
        (0x0000, DriveState.NOT_READY),
        (0x0250, DriveState.SWITCH_ON_DISABLED),
        (0x0231, DriveState.READY),
        (0x0233, DriveState.SWITCHED_ON),
        (0x1637, DriveState.ENABLED),
        (0x0217, DriveState.QUICK_STOP),
        (0x021F, DriveState.FAULT_REACTION),
        (0x0238, DriveState.FAULT),
        (0x0011, None),
    ],
)
def test_the_status_word_s_bits_are_a_state(word: int, state: DriveState | None) -> None:
    assert drive_state(word) is state


@given(st.integers(0, 0xFFFF))
def test_no_status_word_is_two_states(word: int) -> None:
    fitting = [state for state in DriveState if word & state.value[0] == state.value[1]]
    assert len(fitting) <= 1


def test_it_is_looked_at_set_up_and_then_started() -> None:
    bench = Bench()
    bench.hear(heartbeat(BOOT))
    assert bench.sent[0] == CanFrame(0x602, bytes.fromhex("4000100000000000"))
    assert bench.sent[-1] == CanFrame(0x000, bytes.fromhex("0102"))
    assert bench.written[0x1800, 1] == 0x182
    assert [bench.written[0x1A00, sub] for sub in range(3)] == [2, 0x60640020, 0x606C0020]
    assert [bench.written[0x1800, sub] for sub in (2, 3, 5)] == [255, 100, 10]
    assert [bench.written[0x1A01, sub] for sub in range(2)] == [1, 0x60410010]
    assert bench.written[0x1017, 0] == 100
    motors = {0x6040, 0x6060, 0x60FF, 0x6007, 0x1016, 0x1400, 0x1600}
    assert not motors & {index for index, _ in bench.written}


def test_with_sync_the_position_follows_it() -> None:
    bench = Bench(sync="produce", period_ms=20).ready()
    assert bench.written[0x1800, 2] == 1
    assert (0x1800, 5) not in bench.written
    del bench.sent[:]
    for _ in range(10):
        bench.hear(heartbeat(), after_ms=10)
    assert bench.of(0x080) == [b""] * 5


def test_sync_is_sent_for_the_others_while_its_own_drive_is_away_but_not_into_an_empty_bus() -> None:
    bench = Bench(sync="produce")
    bench.mute = True
    bench.hear(after_ms=100)
    assert bench.of(0x080) == []
    bench.hear(CanFrame(0x703, b"\x05"))
    bench.hear(after_ms=600)
    assert len(bench.of(0x080)) == 2


def test_expected_sync_is_not_sent_and_missed_by_name() -> None:
    bench = Bench(sync="expect").ready()
    assert bench.of(0x080) == []
    assert bench.state is State.STALLED and "SYNC" in bench.message


def test_positions_count_only_while_it_is_operational() -> None:
    bench = Bench()
    bench.mute = True
    assert bench.hear(heartbeat(), motion(5)) == []
    assert bench.count("positions before the set-up") == 1
    bench.mute = False
    bench.hear(heartbeat(BOOT))
    assert bench.hear(motion(6)) == []
    bench.hear(heartbeat(PRE_OPERATIONAL))
    assert bench.hear(motion(7)) == []
    assert bench.count("positions of a node that is not operational") == 2
    bench.hear(heartbeat())
    assert len(bench.hear(motion(8))) == 1
    assert bench.state is State.WELL


def test_it_is_started_again_while_it_is_not_operational() -> None:
    bench = Bench().ready()
    del bench.sent[:]
    for _ in range(16):
        bench.hear(heartbeat(PRE_OPERATIONAL), after_ms=100)
    assert bench.of(0x000) == [b"\x01\x02"] * 3
    assert bench.state is State.STALLED and "pre-operational" in bench.message


def test_a_refused_object_is_told_by_name_and_tried_again() -> None:
    bench = Bench()
    bench.refused = {(0x1A00, 2): 0x06040041}
    bench.hear(heartbeat(BOOT))
    assert bench.state is State.FAILED
    assert "1A00h:2: can't be mapped to a PDO (0x06040041)" in bench.message
    assert bench.of(0x000) == []
    bench.refused = {}
    bench.hear(heartbeat(PRE_OPERATIONAL), after_ms=1001)
    bench.hear(heartbeat(), motion(1))
    assert bench.state is State.WELL


def test_another_profile_is_left_alone() -> None:
    bench = Bench()
    bench.device_type = 0x00030191
    bench.hear(heartbeat(BOOT))
    assert bench.state is State.WRONG_DEVICE and "is 401, not 402" in bench.message
    assert bench.written == {}


def test_silence_and_deafness_are_told_apart() -> None:
    bench = Bench()
    bench.mute = True
    for _ in range(20):
        bench.hear(after_ms=100)
    assert bench.state is State.SILENT and "node 2" in bench.message
    for _ in range(20):
        bench.hear(heartbeat(), after_ms=100)
    assert bench.state is State.MISSING


def test_a_boot_up_is_a_restart_and_sets_it_up_again() -> None:
    bench = Bench().ready()
    bench.hear(motion(5000), after_ms=10)
    bench.written.clear()
    bench.hear(heartbeat(BOOT), after_ms=10)
    assert (0x1800, 1) in bench.written
    bench.hear(heartbeat(), after_ms=10)
    given = bench.hear(motion(3), after_ms=10) + bench.hear(motion(5), after_ms=10)
    assert told(given) == [(5000, True), (5002, False)]


@mark.parametrize("lost", [False, True])
def test_after_a_silence_it_is_set_up_again(lost: bool) -> None:
    bench = Bench().ready()
    bench.hear(motion(500_000))
    bench.written.clear()
    if lost:
        bench.device.lost(bench.now_ns)
    bench.mute = True
    bench.hear(after_ms=401)
    assert bench.state is State.SILENT
    bench.mute = False
    bench.hear(heartbeat(), after_ms=2000)
    assert (0x1800, 1) in bench.written
    bench.hear(heartbeat())
    assert told(bench.hear(motion(500_700))) == [(500_700, False)]


@mark.parametrize("direction", [1, -1])
@mark.parametrize("range_counts", [0, 100_000])
def test_the_position_wraps_in_both_directions(direction: int, range_counts: int) -> None:
    half = (range_counts or 1 << 32) // 2
    edge, beyond = (half - 1, -half) if direction > 0 else (-half, half - 1)
    bench = Bench(range_counts=range_counts).ready()
    given = [*bench.hear(motion(edge)), *bench.hear(motion(beyond)), *bench.hear(motion(beyond))]
    assert told(given) == [(edge, False), (edge + direction, False), (edge + direction, False)]


def test_duplicates_are_no_motion_and_swapped_frames_end_where_they_should() -> None:
    bench = Bench().ready()
    given = bench.hear(motion(10), motion(10), motion(14), motion(12), motion(16))
    assert told(given) == [(10, False), (10, False), (14, False), (12, False), (16, False)]


def test_short_foreign_remote_and_extended_frames_are_counted() -> None:
    bench = Bench().ready()
    bench.hear(CanFrame(0x182, bytes(7)), CanFrame(0x702, b""), CanFrame(0x183, bytes(8)))
    bench.hear(CanFrame(0x182, b"", remote=True), CanFrame(0x182, bytes(8), extended=True))
    assert bench.readings == []
    assert bench.count("position frames of a wrong length") == 1
    assert bench.count("heartbeat frames of a wrong length") == 1
    assert bench.count("foreign frames") == 1
    assert bench.count("extended or remote frames") == 2


def test_units_and_gear_make_angle_and_rate() -> None:
    bench = Bench(replace(ROLE, gear=-2.0), velocity_units=60.0).ready()
    (reading,) = bench.hear(motion(PER_TURN, 120))
    assert (reading.angle, reading.rate) == approx((-tau / 2, -tau))


def test_an_emergency_is_told_by_name_until_it_is_taken_back() -> None:
    bench = Bench().ready()
    bench.hear(motion(0), CanFrame(0x082, bytes.fromhex("1073210000000000")))
    assert bench.state is State.FAILED and "0x7310 (speed)" in bench.message
    assert len(bench.hear(motion(1))) == 1
    bench.hear(emergency(0x0000), motion(2))
    assert bench.state is State.WELL


def test_a_fault_in_the_status_word_is_told_with_its_cause() -> None:
    bench = Bench().ready()
    bench.hear(status(FAULT), motion(0))
    assert bench.state is State.FAILED and "its EMCY was not heard" in bench.message
    bench.hear(emergency(0x2310), motion(0))
    assert "continuous over-current" in bench.message


def test_trouble_on_the_bus_is_no_fault_of_the_drive() -> None:
    bench = Bench().ready()
    bench.hear(emergency(0x8130), motion(0))
    assert bench.state is State.WELL and "0x8130" in bench.message


def test_the_positions_of_a_faulty_encoder_are_no_motion() -> None:
    bench = Bench().ready()
    bench.hear(motion(1000))
    bench.hear(emergency(0x7305))
    assert bench.hear(motion(1400)) == []
    bench.hear(emergency(0x0000))
    assert told(bench.hear(motion(1500)) + bench.hear(motion(1501))) == [(1000, True), (1001, False)]


@mark.parametrize("role", [replace(ROLE, listen_only=True), ROLE])
def test_a_drive_that_is_set_up_already_is_only_listened_to(role: WheelRole) -> None:
    bench = Bench(role, configure=role.listen_only, sync="produce")
    given = bench.hear(heartbeat(), motion(1000)) + bench.hear(motion(1001), after_ms=10)
    assert told(given) == [(1000, False), (1001, False)]
    bench.hear(heartbeat(PRE_OPERATIONAL), after_ms=50)
    assert "its master must start it" in bench.message
    bench.hear(heartbeat(BOOT), after_ms=50)
    bench.hear(after_ms=5000)
    assert bench.sent == []
    assert bench.device.step(bench.now_ns, []).deadline_ns == NEVER_NS


def test_positions_without_a_heartbeat_say_what_is_missing() -> None:
    bench = Bench(replace(ROLE, listen_only=True))
    assert bench.hear(motion(1)) == []
    assert bench.state is State.SILENT and "1017h" in bench.message


def test_impossible_jumps_say_what_may_be_wrong() -> None:
    bench = Bench(replace(ROLE, fastest=1.0)).ready()
    bench.hear(motion(0))
    for number in range(1, 60):
        bench.hear(heartbeat(), motion(500_000 * number**2), after_ms=10)
    assert bench.state is State.FAULTY and "counts_per_turn" in bench.message


@mark.parametrize(
    ("wrong", "told_as"),
    [
        ({"node": 0}, "node is 0: expected 1 to 127"),
        ({"counts_per_turn": 0.0}, "counts_per_turn"),
        ({"tpdo": 5}, "tpdo is 5"),
        ({"status_tpdo": 1}, "tpdo and status_tpdo are both 1"),
        ({"master": 2}, "master and node are both 2"),
        ({"period_ms": 0}, "period_ms"),
        ({"range_counts": 3}, "range_counts"),
    ],
)
def test_impossible_settings_are_refused_by_name(wrong: dict[str, Any], told_as: str) -> None:
    with raises(ValueError, match=told_as):
        Bench(**wrong)


def test_a_motor_needs_a_drive_that_may_be_set_up() -> None:
    with raises(ValueError, match="configure = true"):
        Bench(replace(ROLE, throttle=Throttle(10.0, 5.0)), configure=False)
