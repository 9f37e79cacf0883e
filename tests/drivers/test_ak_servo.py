from dataclasses import replace
from math import tau
from struct import pack
from typing import Any

from pytest import approx, mark, raises

from echogrid.drivers.ak_servo import AkServo, decode_upload
from echogrid.drivers.bus import NEVER_NS, CanFrame
from echogrid.drivers.device import Level, State
from echogrid.drivers.readings import WheelReading
from echogrid.drivers.role import WheelRole

MS = 1_000_000
NODE = 0x68
ROLE = WheelRole("left", fastest=20.0)
GOLDEN = CanFrame(0x00002968, bytes.fromhex("FB2E0096FEBF2300"), extended=True, stamp_ns=5 * MS)


def upload(stamp_ns: int, position: int, erpm: int = 0, celsius: int = 35, error: int = 0) -> CanFrame:
    return replace(GOLDEN, data=pack(">hhhbB", position, erpm // 10, 0, celsius, error), stamp_ns=stamp_ns)


def servo(role: WheelRole = ROLE, **settings: Any) -> AkServo:
    return AkServo(role, AkServo.Settings(**{"node": NODE, **settings}))


def readings(device: AkServo, *frames: CanFrame) -> list[WheelReading]:
    given = [reading for each in frames for reading in device.step(each.stamp_ns, [each]).readings]
    return [reading for reading in given if isinstance(reading, WheelReading)]


def told(given: list[WheelReading]) -> list[tuple[int, bool]]:
    return [(round(reading.angle / tau * 3600), reading.discontinuity) for reading in given]


def count(device: AkServo, name: str) -> int:
    return device.health(0).counts[name]


def test_the_known_upload_is_decoded() -> None:
    assert decode_upload(GOLDEN.data) == (-1234, 1500, -3.21, 35, 0)
    assert decode_upload(bytes(6) + b"\xec\x05")[3:] == (-20, 5)


def test_the_known_upload_makes_a_reading() -> None:
    (reading,) = readings(servo(replace(ROLE, gear=-2.0)), GOLDEN)
    assert (reading.stamp_ns, reading.wheel, reading.raw) == (5 * MS, "left", GOLDEN.data)
    assert reading.angle == approx(123.4 / 360 * tau / 2)


def test_the_packet_is_a_setting() -> None:
    device = servo(packet=0x2A)
    assert readings(device, GOLDEN) == []
    assert "0x2a68" in device.health(5 * MS).message
    assert len(readings(device, replace(GOLDEN, identifier=0x2A68))) == 1


@mark.parametrize("direction", [1, -1])
def test_sixteen_bits_wrap_in_both_directions(direction: int) -> None:
    edge, beyond = (32_767, -32_768) if direction > 0 else (-32_768, 32_767)
    given = readings(servo(), upload(1, edge), upload(10 * MS, beyond), upload(20 * MS, beyond + direction))
    assert told(given) == [(edge, False), (edge + direction, False), (edge + 2 * direction, False)]


@mark.parametrize("direction", [1, -1])
def test_a_narrower_span_wraps_where_it_says(direction: int) -> None:
    given = readings(
        servo(span_deg=6400.0), upload(1, 31_990 * direction), upload(10 * MS, -31_990 * direction)
    )
    assert told(given) == [(31_990 * direction, False), (32_010 * direction, False)]


def test_positions_beyond_the_span_are_not_believed() -> None:
    device = servo(span_deg=6400.0)
    assert readings(device, upload(1, 32_001), upload(2, -32_001)) == []
    assert count(device, "positions beyond span_deg") == 2


def rising_to_an_end() -> AkServo:
    device = servo()
    frames = [upload(n * 10 * MS, position, 4000) for n, position in enumerate((31_900, 31_950, 32_000))]
    assert told(readings(device, *frames)) == [(31_900, False), (31_950, False)]
    return device


def test_a_position_that_stops_at_its_end_is_no_wheel_that_stands() -> None:
    device = rising_to_an_end()
    assert readings(device, *(upload(n * 10 * MS, 32_000, 4000) for n in range(3, 100))) == []
    health = device.health(990 * MS)
    assert health.state is State.FAULTY
    assert "stop counting at the end of its range" in health.message
    back = [upload(1000 * MS, 31_990, -4000), upload(1010 * MS, 31_980, -4000)]
    assert told(readings(device, *back)) == [(31_950, True), (31_940, False)]


def test_a_wheel_that_halts_where_its_position_stopped_is_a_discontinuity() -> None:
    given = readings(rising_to_an_end(), upload(30 * MS, 32_000), upload(40 * MS, 32_000))
    assert told(given) == [(31_950, True), (31_950, False)]


def test_a_position_that_goes_on_beyond_an_end_has_lost_nothing() -> None:
    assert told(readings(rising_to_an_end(), upload(30 * MS, 32_050, 4000))) == [(32_050, False)]


def test_a_wheel_may_stand_at_the_end() -> None:
    given = readings(servo(), *(upload(n * 10 * MS, 32_000) for n in range(1, 5)))
    assert told(given) == [(32_000, False)] * 4


def test_a_long_pause_is_a_discontinuity_not_a_guess() -> None:
    given = readings(servo(), upload(1, 20_000), upload(3000 * MS, 21_000), upload(3010 * MS, 21_010))
    assert told(given) == [(20_000, False), (20_000, True), (20_010, False)]


def test_a_restart_in_silence_is_no_motion() -> None:
    given = readings(servo(), upload(1, 20_000), upload(700 * MS, 5), upload(710 * MS, 10))
    assert told(given) == [(20_000, False), (20_000, True), (20_005, False)]


def test_a_lost_port_leaves_silence_and_then_doubt() -> None:
    device = servo()
    readings(device, upload(1, 100))
    device.lost(2)
    assert device.health(3).state is State.SILENT
    assert told(readings(device, upload(50 * MS, 0))) == [(100, True)]


def test_a_faulty_encoder_is_not_believed_and_then_rebased() -> None:
    device = servo()
    readings(device, upload(1, 100))
    assert readings(device, upload(10 * MS, 0, error=5)) == []
    health = device.health(11 * MS)
    assert (health.state, health.message[:13]) == (State.FAILED, "encoder fault")
    assert told(readings(device, upload(20 * MS, 110))) == [(100, True)]


@mark.parametrize(("error", "text"), [(1, "over-temperature"), (6, "unbalanced"), (9, "error 9")])
def test_other_errors_leave_the_position_believed(error: int, text: str) -> None:
    device = servo()
    assert len(readings(device, upload(1, 100, error=error))) == 1
    health = device.health(2)
    assert health.level is Level.ERROR
    assert health.message.startswith(text)


def test_duplicates_are_no_motion_and_older_stamps_are_dropped() -> None:
    device = servo()
    given = readings(device, upload(10 * MS, 10), upload(10 * MS, 10), upload(5 * MS, 4), upload(20 * MS, 12))
    assert told(given) == [(10, False), (10, False), (12, False)]
    assert count(device, "counts out of order") == 1


@mark.parametrize(
    ("wrong", "name"),
    [
        (replace(GOLDEN, identifier=0x2969), "foreign frames"),
        (replace(GOLDEN, data=bytes(7)), "short frames"),
        (replace(GOLDEN, identifier=0x168, extended=False), "standard or remote frames"),
        (replace(GOLDEN, remote=True, data=b""), "standard or remote frames"),
    ],
)
def test_frames_that_tell_nothing_are_counted(wrong: CanFrame, name: str) -> None:
    device = servo()
    assert readings(device, wrong) == []
    assert count(device, name) == 1
    assert device.health(5 * MS).state is State.SILENT


def test_it_sends_nothing_and_waits_for_nothing() -> None:
    step = servo().step(0, [GOLDEN])
    assert (step.send, step.deadline_ns) == ((), NEVER_NS)


def test_health_tells_well_from_hot_and_silent() -> None:
    device = servo()
    assert "0x2968" in device.health(0).message
    readings(device, upload(1, 0, celsius=80))
    assert device.health(2).level is Level.OK
    readings(device, upload(3, 0, celsius=81))
    assert (device.health(4).state, device.health(4).message[:14]) == (State.HOT, "driver at 81 C")
    assert device.health(600 * MS).state is State.SILENT


@mark.parametrize(
    ("settings", "text"),
    [
        ({"node": 256}, "node is 256: expected 0 to 255"),
        ({"packet": -1}, "packet is -1"),
        ({"span_deg": 10.0}, "span_deg is 10.0"),
        ({"hottest_c": 200.0}, "hottest_c is 200.0"),
    ],
)
def test_impossible_settings_are_refused_by_name(settings: dict[str, Any], text: str) -> None:
    with raises(ValueError, match=text):
        servo(**settings)
