from dataclasses import replace
from math import tau
from random import Random
from struct import pack

from pytest import approx, mark, raises

from echogrid.drivers.bus import NEVER_NS, CanFrame
from echogrid.drivers.device import Level, State
from echogrid.drivers.readings import WheelReading
from echogrid.drivers.role import WheelRole
from echogrid.drivers.vesc import Vesc, decode_status, decode_status_4, decode_status_5
from echogrid.drivers.vesc_motor import VescCommands, erpm_per_radian

MS = 1_000_000
NODE = 23
ROLE = WheelRole("left", fastest=100.0)
PER_TURN = 42


def frame(packet: int, data: bytes, stamp_ns: int = 1, node: int = NODE) -> CanFrame:
    return CanFrame(packet << 8 | node, data, extended=True, stamp_ns=stamp_ns)


def tachometer(stamp_ns: int, sixths: int) -> CanFrame:
    return frame(27, pack(">ihh", sixths, 481, 0), stamp_ns)


def speed(stamp_ns: int, erpm: int) -> CanFrame:
    return frame(9, pack(">ihh", erpm, 0, 0), stamp_ns)


def warmth(stamp_ns: int, fet_c: float, motor_c: float) -> CanFrame:
    return frame(16, pack(">hhhh", round(fet_c * 10), round(motor_c * 10), 0, 0), stamp_ns)


def boot(stamp_ns: int) -> CanFrame:
    return frame(57, b"60_MK6", stamp_ns)


def vesc(role: WheelRole = ROLE, **settings: int) -> Vesc:
    return Vesc(role, Vesc.Settings(node=NODE, **settings))


def readings(device: Vesc, *frames: CanFrame) -> list[WheelReading]:
    given = [reading for each in frames for reading in device.step(each.stamp_ns, [each]).readings]
    return [reading for reading in given if isinstance(reading, WheelReading)]


def told(given: list[WheelReading]) -> list[tuple[int, bool]]:
    return [(round(reading.angle / tau * PER_TURN), reading.discontinuity) for reading in given]


def count(device: Vesc, name: str) -> int:
    return device.health(0).counts[name]


def test_the_known_frames_are_decoded() -> None:
    assert decode_status(bytes.fromhex("FFFFEC780064FE0C")) == (-5000, 10.0, -0.5)
    assert decode_status_4(bytes.fromhex("01C7012DFFE7464B")) == approx((45.5, 30.1, -2.5, 359.9), abs=0.01)
    assert decode_status_5(bytes.fromhex("FFFE1DC001E10000")) == (-123456, 48.1)


def test_the_known_tachometer_makes_a_reading() -> None:
    known = CanFrame(0x00001B17, bytes.fromhex("FFFE1DC001E10000"), extended=True, stamp_ns=5 * MS)
    (reading,) = readings(vesc(), known)
    assert (reading.stamp_ns, reading.wheel, reading.raw) == (5 * MS, "left", known.data)
    assert reading.angle == approx(-123456 / 42 * tau)


def test_a_command_to_the_controller_is_no_status_of_it() -> None:
    device = vesc()
    command = CanFrame(0x00000117, bytes.fromhex("0000C738"), extended=True, stamp_ns=1)
    assert readings(device, command) == []
    assert count(device, "other frames") == 1
    assert device.health(1).state is State.SILENT


def test_the_status_that_is_none_does_nothing() -> None:
    device = vesc()
    assert readings(device, frame(28, bytes(8)), frame(58, bytes(8))) == []
    assert count(device, "other frames") == 1


@mark.parametrize(("pole_pairs", "gear"), [(7, 1.0), (15, -1.0), (7, 9.5)])
def test_pole_pairs_and_gear_make_an_angle_of_six_counts_per_electrical_turn(
    pole_pairs: int, gear: float
) -> None:
    device = vesc(replace(ROLE, gear=gear), pole_pairs=pole_pairs)
    given = readings(device, speed(1, 600), tachometer(2, 6 * pole_pairs))
    assert (given[0].angle, given[0].rate) == approx((tau / gear, 10 / pole_pairs * tau / gear))


def test_without_its_speed_the_rate_is_that_of_the_tachometer() -> None:
    device = vesc()
    readings(device, speed(1, 60_000))
    given = readings(device, tachometer(990 * MS, 0), tachometer(1000 * MS, 4))
    assert given[1].rate == approx(400 / 42 * tau)


@mark.parametrize("direction", [1, -1])
def test_the_tachometer_wraps_in_both_directions(direction: int) -> None:
    edge = (1 << 31) - 1 if direction > 0 else -(1 << 31)
    beyond = -(1 << 31) if direction > 0 else (1 << 31) - 1
    given = readings(vesc(), tachometer(1, edge), tachometer(10 * MS, beyond), tachometer(20 * MS, beyond))
    assert told(given) == [(edge, False), (edge + direction, False), (edge + direction, False)]


def test_a_restart_is_no_motion_and_its_notice_is_no_second_one() -> None:
    device = vesc()
    given = readings(
        device,
        tachometer(1, 5000),
        tachometer(900 * MS, 3),
        tachometer(1150 * MS, 5),
        boot(1400 * MS),
        tachometer(1420 * MS, 9),
    )
    assert told(given) == [(5000, False), (5000, True), (5002, False), (5006, False)]
    assert count(device, "boot notices") == 1


def test_a_boot_notice_is_believed_where_nothing_else_showed_the_restart() -> None:
    times = [(n * 20 * MS, 40 + n) for n in range(1, 200)]
    device = vesc()
    readings(device, *(tachometer(*each) for each in times))
    given = readings(device, boot(4000 * MS), tachometer(4010 * MS, 0), tachometer(4020 * MS, 1))
    assert told(given) == [(239, True), (240, False)]


def test_the_boot_notice_of_a_controller_that_was_not_heard_before_is_no_discontinuity() -> None:
    given = readings(vesc(), boot(1), tachometer(2, 0), tachometer(10 * MS, 1))
    assert told(given) == [(0, False), (1, False)]


def test_a_pulled_cable_far_from_zero_loses_no_motion() -> None:
    device = vesc()
    readings(device, tachometer(1, 400_000))
    device.lost(1)
    assert told(readings(device, tachometer(2000 * MS, 400_500))) == [(400_500, False)]


def test_duplicates_are_no_motion_and_swapped_frames_end_where_they_should() -> None:
    frames = [tachometer(10 * MS, 10), tachometer(10 * MS, 10), tachometer(20 * MS, 14)]
    given = readings(vesc(), *frames, tachometer(30 * MS, 12), tachometer(40 * MS, 16))
    assert told(given) == [(10, False), (10, False), (14, False), (12, False), (16, False)]


def test_a_late_stamp_is_dropped() -> None:
    device = vesc()
    assert told(readings(device, tachometer(10 * MS, 10), tachometer(5 * MS, 8))) == [(10, False)]
    assert count(device, "counts out of order") == 1


@mark.parametrize(
    ("wrong", "name"),
    [
        (frame(27, bytes(8), node=24), "foreign frames"),
        (frame(27, bytes(6)), "short frames"),
        (frame(9, b""), "short frames"),
        (replace(tachometer(1, 5), extended=False, identifier=0x717), "standard or remote frames"),
        (replace(tachometer(1, 5), remote=True, data=b""), "standard or remote frames"),
        (frame(18, bytes(8)), "other frames"),
        (frame(0x1_0000 | 27, bytes(8)), "other frames"),
    ],
)
def test_frames_that_tell_nothing_are_counted(wrong: CanFrame, name: str) -> None:
    device = vesc()
    assert readings(device, wrong) == []
    assert count(device, name) == 1
    assert device.health(1).state is State.SILENT


def test_it_sends_nothing_and_waits_for_nothing() -> None:
    step = vesc().step(0, [tachometer(1, 0)])
    assert (step.send, step.deadline_ns) == ((), NEVER_NS)


def test_silence_names_the_id_and_whoever_else_is_heard() -> None:
    device = vesc()
    assert "VESC 23:" in device.health(0).message
    readings(device, frame(9, bytes(8), node=7), frame(9, bytes(8), node=5), frame(1, bytes(4), node=9))
    assert device.health(0).state is State.SILENT
    assert "(heard of: 5, 7)" in device.health(0).message


def test_without_the_tachometer_health_says_which_bit_to_set() -> None:
    device = vesc()
    readings(device, speed(1, 0))
    health = device.health(2)
    assert health.state is State.STALLED
    assert "STATUS_5 (bit 4, 0x10, of can_status_msgs_r1)" in health.message


def test_it_is_well_until_half_a_second_after_the_last_tachometer() -> None:
    device = vesc()
    readings(device, tachometer(1, 0))
    assert device.health(500 * MS).level is Level.OK
    readings(device, speed(490 * MS, 0))
    assert device.health(600 * MS).state is State.STALLED
    assert device.health(1000 * MS).state is State.SILENT


def test_jumps_without_end_are_a_fault_that_names_the_settings() -> None:
    device, random = vesc(), Random(1)
    readings(device, *(tachometer(n * 10 * MS, random.randrange(-(1 << 31), 1 << 31)) for n in range(1, 100)))
    health = device.health(1000 * MS)
    assert health.state is State.FAULTY
    assert "pole_pairs" in health.message


def test_what_is_too_warm_is_named() -> None:
    device = vesc()
    readings(device, tachometer(1, 0), warmth(2, 84.9, 40.0))
    assert device.health(3).state is State.WELL
    readings(device, warmth(4, 85.1, 120.0))
    health = device.health(5)
    assert (health.state, health.level) == (State.HOT, Level.WARN)
    assert health.message.startswith("FETs at 85.1 C, motor at 120.0 C")


def test_an_old_temperature_says_nothing() -> None:
    device = vesc()
    readings(device, warmth(1, 99.0, 40.0), tachometer(6000 * MS, 0))
    assert device.health(6000 * MS).state is State.WELL


def test_a_lost_port_leaves_silence() -> None:
    device = vesc()
    readings(device, tachometer(1, 0))
    device.lost(2)
    assert device.health(3).state is State.SILENT


@mark.parametrize(
    ("settings", "text"),
    [
        ({"node": 255}, "node is 255: expected 0 to 254"),
        ({"pole_pairs": 0}, "pole_pairs is 0: expected 1 to 100"),
        ({"hottest_fet_c": -1}, "hottest_fet_c is -1"),
        ({"hottest_motor_c": 999}, "hottest_motor_c is 999"),
    ],
)
def test_impossible_settings_are_refused_by_name(settings: dict[str, int], text: str) -> None:
    with raises(ValueError, match=text):
        Vesc.Settings(**settings)


def test_its_commands_are_big_endian_and_signed() -> None:
    commands = VescCommands(23, erpm_per_radian(-2.0, 7), 51.0)
    (turn,), (brake,) = commands.drive(3.0), commands.drive(0.0)
    assert (turn.identifier, turn.extended) == (0x0317, True)
    assert int.from_bytes(turn.data, "big", signed=True) == round(-3.0 / tau * 60 * 7 * 2)
    assert (brake.identifier, brake.data) == (0x0217, bytes.fromhex("00 00 C7 38"))
    assert list(commands.enable()) == []
    assert commands.let_go() == (brake,)
