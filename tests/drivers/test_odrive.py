import itertools
from dataclasses import replace
from math import inf, isfinite, nan, tau
from struct import pack

from hypothesis import given
from hypothesis.strategies import binary, booleans, builds, floats, integers, lists, one_of, sampled_from
from pytest import approx, mark, raises

from echogrid.drivers.bus import NEVER_NS, CanFrame
from echogrid.drivers.cansimple import AxisState, decode_counts, decode_estimates
from echogrid.drivers.device import Level, State
from echogrid.drivers.odrive import ODriveAxis, decode_heartbeat
from echogrid.drivers.readings import WheelReading
from echogrid.drivers.role import WheelRole
from echogrid.drivers.throttle import Throttle

MS = 1_000_000
NODE = 3
ROLE = WheelRole("left", fastest=100.0)
IDLE, CLOSED_LOOP = 1, 8


def heartbeat(stamp_ns: int, state: int = CLOSED_LOOP, error: int = 0, flags: bytes = bytes(3)) -> CanFrame:
    return CanFrame(NODE << 5 | 0x001, pack("<IB", error, state) + flags, stamp_ns=stamp_ns)


def estimates(stamp_ns: int, turns: float, rate: float = 0.0) -> CanFrame:
    return CanFrame(NODE << 5 | 0x009, pack("<ff", turns, rate), stamp_ns=stamp_ns)


def version(stamp_ns: int, major: int = 0, minor: int = 6, revision: int = 10) -> CanFrame:
    return CanFrame(NODE << 5, bytes([2, 4, 4, 58, major, minor, revision, 0]), stamp_ns=stamp_ns)


def axis(role: WheelRole = ROLE) -> ODriveAxis:
    return ODriveAxis(role, ODriveAxis.Settings(node=NODE))


def readings(device: ODriveAxis, *frames: CanFrame) -> list[WheelReading]:
    given = [reading for frame in frames for reading in device.step(frame.stamp_ns, [frame]).readings]
    return [reading for reading in given if isinstance(reading, WheelReading)]


def count(device: ODriveAxis, name: str) -> int:
    return device.health(0).counts[name]


def test_the_known_heartbeats_are_decoded() -> None:
    beat = decode_heartbeat(bytes.fromhex("00 00 00 00 08 00 00 80"))
    assert (beat.state, beat.error, beat.trajectory_done, beat.faults) == (CLOSED_LOOP, 0, True, "")
    assert decode_heartbeat(bytes.fromhex("00 00 00 00 01 00 00 00")).state == IDLE


def test_the_known_estimates_are_decoded() -> None:
    assert decode_estimates(bytes.fromhex("00 00 C0 3F 00 00 10 C0")) == (1.5, -2.25)


def test_the_flags_of_a_heartbeat_are_told_apart() -> None:
    parts = [decode_heartbeat(bytes(5) + flags).faults for flags in (b"\1\0\0", b"\0\1\0", b"\0\0\1")]
    assert parts == ["motor error", "encoder error", "controller error"]


@mark.parametrize(
    ("error", "text"),
    [
        (0x840, "MOTOR_FAILED, WATCHDOG_TIMER_EXPIRED"),
        (0x140, "MOTOR_FAILED, ENCODER_FAILED"),
        (0x2, "axis error 0x2"),
    ],
)
def test_axis_errors_have_names(error: int, text: str) -> None:
    device = axis()
    readings(device, heartbeat(0, error=error))
    health = device.health(0)
    assert health.level is Level.ERROR
    assert health.message.startswith(text)


def test_an_axis_that_nobody_commands_is_well_though_its_watchdog_has_expired() -> None:
    device = axis()
    (reading,) = readings(device, heartbeat(0, IDLE, error=0x800), estimates(MS, 1.5))
    assert reading.angle == approx(1.5 * tau)
    assert device.health(MS).state is State.WELL


def test_an_axis_that_somebody_else_has_enabled_is_not_driven() -> None:
    throttle = Throttle(10.0, 10.0)
    settings = ODriveAxis.Settings(node=NODE, watchdog=True)
    device, sent = ODriveAxis(replace(ROLE, throttle=throttle), settings), []
    for stamp_ns in range(0, 3000 * MS, 100 * MS):
        throttle.ask(stamp_ns, 0.0)
        frames = [heartbeat(stamp_ns, CLOSED_LOOP), estimates(stamp_ns, 1.0)]
        sent += device.step(stamp_ns, frames).send
    assert {frame.identifier for frame in sent} == {NODE << 5}
    assert not throttle.obeyed
    assert "in closed loop by somebody else" in device.health(stamp_ns).message


def test_without_its_own_watchdog_an_axis_is_not_driven() -> None:
    with raises(ValueError, match="enable_watchdog at the controller, then watchdog = true here"):
        axis(replace(ROLE, throttle=Throttle(1.0, 1.0)))


def test_the_known_frames_make_a_reading() -> None:
    frame = CanFrame(0x069, bytes.fromhex("00 00 C0 3F 00 00 10 C0"), stamp_ns=5 * MS)
    (reading,) = readings(axis(), heartbeat(0), frame)
    assert (reading.stamp_ns, reading.wheel, reading.raw) == (5 * MS, "left", frame.data)
    assert (reading.angle, reading.rate) == approx((1.5 * tau, -2.25 * tau))


@mark.parametrize("gear", [10.0, -2.5])
def test_the_gear_turns_encoder_turns_into_wheel_angle(gear: float) -> None:
    (reading,) = readings(axis(replace(ROLE, gear=gear)), heartbeat(0), estimates(1, 5.0, 1.0))
    assert (reading.angle, reading.rate) == approx((5.0 * tau / gear, tau / gear))


def test_no_estimate_is_believed_before_a_heartbeat() -> None:
    device = axis()
    assert readings(device, estimates(0, 1.0)) == []
    assert count(device, "positions without heartbeat") == 1


def test_no_estimate_is_believed_half_a_second_after_the_last_heartbeat() -> None:
    given = readings(axis(), heartbeat(0), estimates(500 * MS, 1.0), estimates(501 * MS, 1.0))
    assert len(given) == 1


@mark.parametrize("state", list(AxisState))
def test_no_estimate_is_believed_in_a_state_that_may_zero_it(state: AxisState) -> None:
    device = axis()
    assert readings(device, heartbeat(0, state=state), estimates(1, 1.0)) == []
    assert device.health(1).level is Level.WARN
    assert state.name in device.health(1).message


@mark.parametrize("wrong", [heartbeat(0, error=0x1), heartbeat(0, flags=b"\0\1\0")])
def test_no_estimate_is_believed_from_a_faulty_encoder_or_axis(wrong: CanFrame) -> None:
    device = axis()
    assert readings(device, wrong, estimates(1, 0.0)) == []
    assert device.health(1).level is Level.ERROR


@mark.parametrize("flags", [b"\1\0\0", b"\0\0\1"])
def test_a_motor_or_controller_error_leaves_the_encoder_believed(flags: bytes) -> None:
    device = axis()
    assert len(readings(device, heartbeat(0, flags=flags), estimates(1, 0.0))) == 1
    assert device.health(1).level is Level.ERROR


def test_a_reboot_seen_is_no_motion() -> None:
    given = readings(
        axis(),
        heartbeat(0),
        estimates(1 * MS, 0.3),
        heartbeat(100 * MS, state=AxisState.STARTUP),
        estimates(110 * MS, 0.0),
        heartbeat(200 * MS, state=IDLE),
        estimates(210 * MS, 0.01),
        estimates(220 * MS, 0.02),
    )
    assert [r.angle / tau for r in given] == [approx(0.3), approx(0.3), approx(0.31)]
    assert [r.discontinuity for r in given] == [False, True, False]


def test_a_reboot_in_silence_is_no_motion() -> None:
    given = readings(
        axis(), heartbeat(0), estimates(1 * MS, 40.0), heartbeat(4000 * MS), estimates(4010 * MS, 0.02)
    )
    assert [r.discontinuity for r in given] == [False, True]
    assert given[1].angle == approx(40.0 * tau)


@mark.parametrize("told", [True, False])
def test_a_pulled_cable_loses_no_motion(told: bool) -> None:
    device = axis()
    readings(device, heartbeat(0), estimates(1 * MS, 40.0, 2.0))
    if told:
        device.lost(1000 * MS)
    (reading,) = readings(device, heartbeat(3000 * MS), estimates(3010 * MS, 46.0, 2.0))
    assert (reading.angle, reading.discontinuity) == approx((46.0 * tau, False))


def test_after_a_lost_port_a_new_heartbeat_is_needed() -> None:
    device = axis()
    readings(device, heartbeat(0))
    device.lost(1)
    assert readings(device, estimates(2, 1.0)) == []


def test_an_impossible_jump_is_no_motion_once_a_second_estimate_confirms_it() -> None:
    given = readings(
        axis(),
        heartbeat(0),
        estimates(0, 1.0),
        estimates(10 * MS, 49.9),
        estimates(20 * MS, 50.0),
        estimates(30 * MS, 50.1),
    )
    assert [r.angle / tau for r in given] == [approx(1.0), approx(1.0), approx(1.1, abs=1e-5)]
    assert [r.discontinuity for r in given] == [False, True, False]


def test_a_single_estimate_far_off_is_dropped() -> None:
    device = axis()
    given = readings(
        device, heartbeat(0), estimates(0, 1.0), estimates(10 * MS, 50.0), estimates(20 * MS, 1.1)
    )
    assert [r.angle / tau for r in given] == [approx(1.0), approx(1.1)]
    assert not any(r.discontinuity for r in given)
    assert count(device, "doubtful jumps") == 1


def test_estimates_of_two_times_that_come_interleaved_end_in_the_newest() -> None:
    device = axis(replace(ROLE, fastest=30.0))
    frames = [
        estimates((n // 2) * 10 * MS + 1 + n % 2, 20.0 + 0.01 * (n // 2) - 0.5 * (n % 2)) for n in range(40)
    ]
    given = readings(
        device, heartbeat(0), *frames, *(estimates((20 + n) * 10 * MS, 20.2 + 0.01 * n) for n in range(5))
    )
    assert given[-1].angle == approx(20.24 * tau, rel=1e-5)
    assert not any(r.discontinuity for r in given)


def test_an_encoder_that_fails_between_heartbeats_is_not_believed_to_stand_at_zero() -> None:
    device = axis()
    given = readings(
        device,
        heartbeat(0),
        estimates(1 * MS, 0.3, 0.5),
        estimates(10 * MS, 0.0),
        estimates(20 * MS, 0.0),
        heartbeat(100 * MS, flags=b"\0\1\0"),
        estimates(110 * MS, 0.0),
        heartbeat(200 * MS),
        estimates(210 * MS, 0.4, 0.5),
    )
    assert [r.angle / tau for r in given] == [approx(0.3), approx(0.4)]
    assert not any(r.discontinuity for r in given)
    assert count(device, "estimates suddenly zero") == 2


def test_a_wheel_that_stands_at_zero_is_believed_after_the_next_heartbeat() -> None:
    given = readings(
        axis(),
        heartbeat(0),
        estimates(1, 0.1),
        heartbeat(10 * MS),
        estimates(10 * MS, 0.0),
        heartbeat(100 * MS),
        estimates(101 * MS, 0.0),
    )
    assert [r.angle for r in given] == [approx(0.1 * tau), 0.0]


def test_frames_read_late_in_one_go_are_no_jump() -> None:
    frames = [heartbeat(0), *(estimates(1 + n, 0.1 * n, 10.0) for n in range(10))]
    given = axis().step(500 * MS, frames).readings
    assert len(given) == 10
    assert not any(isinstance(r, WheelReading) and r.discontinuity for r in given)


def test_a_duplicate_is_no_motion_and_an_older_frame_is_dropped() -> None:
    device = axis()
    first = estimates(10 * MS, 1.0)
    given = readings(device, heartbeat(0), first, first, estimates(5 * MS, 0.9), estimates(20 * MS, 1.1))
    assert [r.angle / tau for r in given] == [approx(1.0), approx(1.0), approx(1.1)]
    assert count(device, "estimates out of order") == 1


def test_far_from_zero_the_steps_of_float32_are_no_jump() -> None:
    frames = [estimates(n * 10 * MS, 100_000.0 + 0.001 * n) for n in range(1, 30)]
    given = readings(axis(replace(ROLE, fastest=1.0)), heartbeat(0), *frames)
    assert len(given) == 29
    assert not any(r.discontinuity for r in given)


@mark.parametrize(
    ("frame", "name"),
    [
        (replace(estimates(1, 1.0), identifier=0x089), "foreign frames"),
        (replace(estimates(1, 1.0), data=b"\0\0\0\0"), "short frames"),
        (replace(heartbeat(1), data=b""), "short frames"),
        (replace(estimates(1, 1.0), remote=True, data=b""), "extended or remote frames"),
        (replace(estimates(1, 1.0), extended=True), "extended or remote frames"),
        (CanFrame(NODE << 5 | 0x017, bytes(8)), "other frames"),
        (estimates(1, nan), "estimates not finite"),
        (estimates(1, 0.0, inf), "estimates not finite"),
        (estimates(1, 1e30), "estimates out of range"),
        (estimates(1, 0.0, 1e5), "estimates out of range"),
    ],
)
def test_frames_that_tell_nothing_are_counted(frame: CanFrame, name: str) -> None:
    device = axis()
    assert readings(device, heartbeat(0), frame) == []
    assert count(device, name) == 1


FRAMES = one_of(
    builds(
        CanFrame, integers(0, 0x7FF), binary(max_size=8), booleans(), booleans(), integers(0, 10_000 * MS)
    ),
    builds(
        CanFrame,
        sampled_from([0x060, 0x061, 0x069]),
        binary(min_size=8, max_size=8),
        stamp_ns=integers(0, 10_000 * MS),
    ),
    builds(heartbeat, integers(0, 10_000 * MS)),
    builds(estimates, integers(0, 10_000 * MS), floats(width=32), floats(-20, 20, width=32)),
)


@given(lists(FRAMES, max_size=60))
def test_random_frames_raise_nothing_and_move_no_wheel_faster_than_it_can(frames: list[CanFrame]) -> None:
    device = axis()
    given = readings(device, *frames)
    for old, new in itertools.pairwise(given):
        assert (
            abs(new.angle - old.angle) <= ROLE.fastest * ((new.stamp_ns - old.stamp_ns) * 1e-9 + 0.02) + 1e-3
        )
    assert all(isfinite(r.angle) and abs(r.rate) <= 2 * ROLE.fastest for r in given)
    assert device.health(0).message


def test_an_axis_that_is_only_listened_to_is_sent_nothing_and_waited_for_by_nothing() -> None:
    device = axis(replace(ROLE, listen_only=True))
    steps = [device.step(n * MS, [heartbeat(n * 100 * MS), estimates(n * 100 * MS, 1.0)]) for n in range(200)]
    assert {(step.send, step.deadline_ns) for step in steps} == {((), NEVER_NS)}


def requests(device: ODriveAxis, *frames: CanFrame) -> int:
    sent = [frame for each in frames for frame in device.step(each.stamp_ns, [each]).send]
    assert all(frame == CanFrame(0x060, b"", remote=True) for frame in sent)
    return len(sent)


def test_the_version_is_asked_for_a_few_times_and_never_without_a_heartbeat() -> None:
    device = axis()
    assert requests(device, *(estimates(n * MS, 1.0) for n in range(100))) == 0
    assert requests(device, *(heartbeat(n * 100 * MS) for n in range(1, 1000))) == 5


def test_it_is_asked_again_after_it_was_away() -> None:
    device = axis()
    assert requests(device, *(heartbeat(n * 100 * MS) for n in range(20))) == 5
    assert requests(device, *(heartbeat(n * 100 * MS) for n in range(30, 60))) == 5


def test_a_starting_axis_is_not_asked() -> None:
    assert requests(axis(), *(heartbeat(n * 100 * MS, state=AxisState.STARTUP) for n in range(20))) == 0


def test_an_axis_of_0_6_is_told_as_the_wrong_device_with_the_mend() -> None:
    device = axis()
    assert readings(device, heartbeat(0), version(1 * MS), estimates(2 * MS, 1.0)) == []
    health = device.health(3 * MS)
    assert (health.state, health.message) == (
        State.WRONG_DEVICE,
        'its firmware is 0.6.10: set driver = "odrive-0.6"',
    )
    assert health.counts["positions of another firmware"] == 1


def test_a_firmware_without_a_driver_is_told_as_that() -> None:
    device = axis()
    readings(device, heartbeat(0), version(1 * MS, 1, 2, 3))
    assert device.health(2 * MS).message == "its firmware is 1.2.3: there is no driver for it"


@mark.parametrize("result", [2, 3, 15])
def test_a_procedure_result_of_0_6_is_no_motor_error_even_if_nobody_may_ask(result: int) -> None:
    device = axis(replace(ROLE, listen_only=True))
    assert readings(device, heartbeat(0, flags=bytes([result, 0, 0])), estimates(1, 1.0)) == []
    assert device.health(1).state is State.WRONG_DEVICE
    assert "odrive-0.6" in device.health(1).message


def test_a_result_that_reads_like_a_motor_error_is_doubtful_until_the_version_is_known() -> None:
    device = axis()
    busy = [heartbeat(n * 100 * MS, flags=b"\1\0\0") for n in range(6)]
    readings(device, busy[0])
    assert device.health(0).message.endswith("(or is its firmware 0.6?)")
    readings(device, *busy[1:])
    assert device.health(500 * MS).message == "motor error: clear it at the controller"


def test_a_version_that_was_garbled_is_forgotten_once_nobody_repeats_it() -> None:
    device = axis()
    readings(device, heartbeat(0), version(1 * MS, 77, 5, 3))
    readings(device, *(heartbeat(n * 100 * MS) for n in range(1, 220)))
    assert device.health(21_900 * MS).state is not State.WRONG_DEVICE


def test_a_request_by_another_host_or_canopen_is_no_version() -> None:
    device = ODriveAxis(ROLE, ODriveAxis.Settings(node=0))
    frames = [CanFrame(0, b"\1\2", stamp_ns=1), CanFrame(0, b"", remote=True, stamp_ns=2)]
    readings(device, CanFrame(1, bytes.fromhex("0000000001000000"), stamp_ns=1), *frames)
    assert device.health(3).state is State.STALLED


def counted(role: WheelRole = ROLE) -> ODriveAxis:
    return ODriveAxis(role, ODriveAxis.Settings(node=NODE, counts_per_turn=8192))


def counts(stamp_ns: int, shadow: int) -> CanFrame:
    return CanFrame(NODE << 5 | 0x00A, pack("<ii", shadow, shadow % 8192), stamp_ns=stamp_ns)


def test_the_known_counts_are_decoded() -> None:
    assert decode_counts(bytes.fromhex("FB FF FF FF FB 1F 00 00")) == (-5, 8187)


def test_the_known_counts_make_a_reading() -> None:
    frame = CanFrame(0x06A, bytes.fromhex("FB FF FF FF FB 1F 00 00"), stamp_ns=5 * MS)
    (reading,) = readings(counted(), heartbeat(0), frame)
    assert reading.angle == approx(-5 / 8192 * tau)


@given(integers(-(1 << 31), (1 << 31) - 1), lists(integers(-100, 100), min_size=1, max_size=50))
def test_counts_wrap_either_way_without_a_jump(start: int, steps: list[int]) -> None:
    total, frames = start, [heartbeat(0), counts(1, start)]
    for n, step in enumerate(steps):
        total += step
        frames.append(counts((n + 1) * 2 * MS, (total + (1 << 31)) % (1 << 32) - (1 << 31)))
    given = readings(counted(), *frames)
    assert given[-1].angle - given[0].angle == approx((total - start) / 8192 * tau, abs=1e-9)
    assert not any(reading.discontinuity for reading in given)


def test_with_counts_estimates_are_not_read() -> None:
    device = counted()
    assert readings(device, heartbeat(0), estimates(1, 1.0)) == []
    assert count(device, "other frames") == 1
    assert "encoder_count_rate_ms" in device.health(2).message


def test_a_restart_of_the_counts_is_no_motion() -> None:
    given = readings(
        counted(),
        heartbeat(0),
        counts(1 * MS, 2457),
        heartbeat(100 * MS, state=AxisState.STARTUP),
        heartbeat(200 * MS, state=IDLE),
        counts(210 * MS, 0),
        counts(220 * MS, 82),
    )
    assert [r.discontinuity for r in given] == [False, True, False]
    assert given[2].angle - given[0].angle == approx(82 / 8192 * tau)


@mark.parametrize("wrong", [heartbeat(0, error=0x1), heartbeat(0, flags=b"\0\1\0"), heartbeat(0, state=0)])
def test_counts_are_gated_by_the_heartbeat_too(wrong: CanFrame) -> None:
    assert readings(counted(), wrong, counts(1, 5)) == []


def test_health_tells_turning_from_half_silence_and_silence() -> None:
    device = axis()
    assert device.health(0).level is Level.STALE
    assert "node 3" in device.health(0).message
    readings(device, heartbeat(0))
    assert "encoder_rate_ms" in device.health(1).message
    readings(device, estimates(1, 0.0))
    assert device.health(1).level is Level.OK
    assert device.health(600 * MS).level is Level.STALE


def test_an_impossible_node_is_refused_by_name() -> None:
    with raises(ValueError, match="node is 64: expected 0 to 63"):
        ODriveAxis.Settings(node=64)


def test_an_impossible_count_is_refused_by_name() -> None:
    with raises(ValueError, match="counts_per_turn is -1: expected 0 to"):
        ODriveAxis.Settings(counts_per_turn=-1)
