from dataclasses import replace
from math import isfinite, tau
from struct import pack

from hypothesis import given
from hypothesis.strategies import binary, booleans, builds, floats, integers, lists, one_of, sampled_from
from pytest import approx, mark

from echogrid.drivers.bus import CanFrame
from echogrid.drivers.cansimple import AxisState
from echogrid.drivers.device import Level, State
from echogrid.drivers.odrive06 import ODrive06Axis, decode_heartbeat
from echogrid.drivers.odrive_axis import AxisSettings
from echogrid.drivers.odrive_inquiry import REQUESTS
from echogrid.drivers.readings import WheelReading
from echogrid.drivers.role import WheelRole

MS = 1_000_000
NODE = 3
ROLE = WheelRole("left", fastest=100.0)
IDLE, CLOSED_LOOP = 1, 8
INITIALIZING, MISSING_ESTIMATE, UNDER_VOLTAGE = 0x1, 0x8, 0x200


def heartbeat(stamp_ns: int, state: int = CLOSED_LOOP, error: int = 0, last: bytes = bytes(3)) -> CanFrame:
    return CanFrame(NODE << 5 | 0x001, pack("<IB", error, state) + last, stamp_ns=stamp_ns)


def estimates(stamp_ns: int, turns: float, rate: float = 0.0) -> CanFrame:
    return CanFrame(NODE << 5 | 0x009, pack("<ff", turns, rate), stamp_ns=stamp_ns)


def version(stamp_ns: int, major: int = 0, minor: int = 6, revision: int = 10) -> CanFrame:
    return CanFrame(NODE << 5, bytes([2, 4, 4, 58, major, minor, revision, 0]), stamp_ns=stamp_ns)


def axis(listen_only: bool = False) -> ODrive06Axis:
    return ODrive06Axis(replace(ROLE, listen_only=listen_only), ODrive06Axis.Settings(NODE))


def known() -> ODrive06Axis:
    device = axis()
    readings(device, heartbeat(0), version(0))
    return device


def readings(device: ODrive06Axis, *frames: CanFrame) -> list[WheelReading]:
    given = [reading for frame in frames for reading in device.step(frame.stamp_ns, [frame]).readings]
    return [reading for reading in given if isinstance(reading, WheelReading)]


def test_a_heartbeat_is_decoded() -> None:
    beat = decode_heartbeat(bytes.fromhex("08 02 00 00 01 0E 01 00"))
    assert (beat.error, beat.state, beat.result, beat.trajectory_done) == (0x208, IDLE, 14, True)
    assert beat.faults == "MISSING_ESTIMATE, DC_BUS_UNDER_VOLTAGE, last procedure NOT_CALIBRATED"


@mark.parametrize(
    ("error", "faults"),
    [(0x1, ""), (0x4000_0000, "CALIBRATION_ERROR"), (0x8000_0020, "DRV_FAULT, axis error 0x80000000")],
)
def test_errors_have_the_names_of_0_6(error: int, faults: str) -> None:
    assert decode_heartbeat(pack("<IBBBB", error, IDLE, 0, 0, 0)).faults == faults


def test_a_result_without_a_name_is_told_as_a_number() -> None:
    assert decode_heartbeat(pack("<IBBBB", 0x20, IDLE, 99, 0, 0)).faults == "DRV_FAULT, last procedure 99"


def test_the_known_estimates_make_a_reading() -> None:
    frame = CanFrame(0x069, bytes.fromhex("00 00 C0 3F 00 00 10 C0"), stamp_ns=5 * MS)
    (reading,) = readings(known(), frame)
    assert (reading.angle, reading.rate) == approx((1.5 * tau, -2.25 * tau))


@mark.parametrize("result", range(16))
def test_no_procedure_result_is_a_fault_by_itself(result: int) -> None:
    device = known()
    assert len(readings(device, heartbeat(1, last=bytes([result, 1, 0])), estimates(2, 1.0))) == 1
    assert device.health(3).level is Level.OK


@mark.parametrize("error", [INITIALIZING, MISSING_ESTIMATE, MISSING_ESTIMATE | UNDER_VOLTAGE])
def test_no_estimate_is_believed_without_one_at_the_controller(error: int) -> None:
    device = known()
    assert readings(device, heartbeat(1, error=error), estimates(2, 0.0)) == []
    assert device.health(3).level is not Level.OK


@mark.parametrize("state", list(AxisState))
def test_no_estimate_is_believed_in_a_state_that_may_zero_it(state: AxisState) -> None:
    device = known()
    assert readings(device, heartbeat(1, state=state), estimates(2, 1.0)) == []
    assert state.name in device.health(3).message


def test_a_motor_without_supply_leaves_the_encoder_believed() -> None:
    device = known()
    assert len(readings(device, heartbeat(1, error=UNDER_VOLTAGE), estimates(2, 1.0))) == 1
    assert device.health(3).message == "DC_BUS_UNDER_VOLTAGE: clear it at the controller"


def test_initializing_is_a_restart() -> None:
    given = readings(
        known(),
        estimates(1 * MS, 0.3),
        heartbeat(100 * MS, state=IDLE, error=INITIALIZING),
        heartbeat(200 * MS, state=IDLE),
        estimates(210 * MS, 0.01),
    )
    assert [r.angle / tau for r in given] == [approx(0.3), approx(0.3)]
    assert [r.discontinuity for r in given] == [False, True]


def test_nothing_is_believed_before_the_version_is_known() -> None:
    device = axis()
    assert readings(device, heartbeat(0), estimates(1, 1.0)) == []
    assert device.health(2).state is State.SETTING_UP
    assert len(readings(device, version(3), estimates(4, 1.0))) == 1
    assert device.health(5).state is State.WELL


def test_the_request_is_a_remote_frame_of_command_0() -> None:
    assert axis().step(0, [heartbeat(0)]).send == (CanFrame(0x060, b"", remote=True),)


def test_an_axis_that_has_answered_is_not_asked_again() -> None:
    device = known()
    assert not any(device.step(n * MS, [heartbeat(n * 100 * MS)]).send for n in range(1, 500))


def test_an_axis_of_0_5_is_told_as_the_wrong_device_with_the_mend() -> None:
    device = axis()
    beats = [heartbeat(n * 100 * MS) for n in range(REQUESTS + 1)]
    assert readings(device, *beats, estimates(501 * MS, 1.0)) == []
    health = device.health(501 * MS)
    assert health.state is State.WRONG_DEVICE
    assert 'set driver = "odrive-0.5"' in health.message
    assert health.counts["version requests"] == REQUESTS


def test_an_axis_that_gives_no_answer_is_asked_again_seldom_and_believed_once_it_does() -> None:
    device = axis()
    beats = [heartbeat(n * 100 * MS) for n in range(200)]
    readings(device, *beats)
    assert device.health(19_900 * MS).counts["version requests"] == 2 * REQUESTS
    assert len(readings(device, version(19_950 * MS), estimates(19_960 * MS, 1.0))) == 1
    assert device.health(19_960 * MS).state is State.WELL


def test_one_that_is_only_listened_to_is_believed_to_be_of_0_6() -> None:
    device = axis(listen_only=True)
    steps = [device.step(n, [heartbeat(n * 100 * MS)]) for n in range(20)]
    assert not any(step.send for step in steps)
    assert len(readings(device, estimates(2000 * MS, 1.0))) == 1
    assert device.health(2000 * MS).state is State.WELL


def test_one_that_is_only_listened_to_shows_0_5_by_its_controllers_flags() -> None:
    device = axis(listen_only=True)
    assert readings(device, heartbeat(0, last=b"\0\0\x80"), estimates(1, 1.0)) == []
    assert device.health(1).message == 'its heartbeat is none of firmware 0.6: set driver = "odrive-0.5"'


def test_the_word_of_the_controller_counts_more_than_a_byte_that_has_no_meaning_yet() -> None:
    device = known()
    assert len(readings(device, heartbeat(1, last=b"\0\0\x80"), estimates(2, 1.0))) == 1


def test_after_it_was_away_the_version_is_asked_for_again() -> None:
    device = known()
    assert device.step(0, [heartbeat(3000 * MS)]).send
    assert readings(device, estimates(3001 * MS, 1.0)) == []


FRAMES = one_of(
    builds(CanFrame, integers(0, 0x7FF), binary(max_size=8), booleans(), booleans(), integers(0, 10**10)),
    builds(
        CanFrame,
        sampled_from([0x060, 0x061, 0x069]),
        binary(min_size=8, max_size=8),
        stamp_ns=integers(0, 10**10),
    ),
    builds(heartbeat, integers(0, 10**10)),
    builds(version, integers(0, 10**10)),
    builds(estimates, integers(0, 10**10), floats(width=32), floats(-20, 20, width=32)),
)


@given(lists(FRAMES, max_size=60), booleans())
def test_random_frames_raise_nothing_and_give_nothing_that_cannot_be(
    frames: list[CanFrame], listen_only: bool
) -> None:
    device = axis(listen_only)
    assert all(isfinite(r.angle) and abs(r.rate) <= 2 * ROLE.fastest for r in readings(device, *frames))
    assert device.health(0).message


def test_both_firmwares_share_their_settings() -> None:
    assert ODrive06Axis.Settings is AxisSettings
