from itertools import pairwise
from math import isfinite, nan, tau
from pathlib import Path
from random import Random
from struct import pack
from typing import Any

from hypothesis import given
from hypothesis.strategies import integers, lists
from pytest import approx, fixture, importorskip, mark, raises

from echogrid.drivers.bus import NEVER_NS, CanFrame
from echogrid.drivers.dbc_wheel import DbcWheel
from echogrid.drivers.device import State
from echogrid.drivers.readings import WheelReading
from echogrid.drivers.role import WheelRole
from echogrid.emulation.buses.can_bus import CanBus
from echogrid.emulation.devices.odrive import ODriveAxis, ODriveOptions

importorskip("cantools", reason="cantools is not installed")

MS = 1_000_000
SECOND = 1000 * MS
ROLE = WheelRole("left", fastest=100.0)
CONTROLLER = """VERSION ""

BO_ 5 Encoder: 6 X
 SG_ Count : 7|16@0+ (1,0) [0|0] "counts" Y
 SG_ Backwards : 16|32@1- (-0.001,0) [0|0] "rad" Y

BO_ 6 Motion: 8 X
 SG_ Turns : 0|32@1- (1,0) [0|0] "" Y
 SG_ Rpm : 32|16@1+ (0.1,0) [0|0] "rpm" Y

BO_ 105 Heard: 8 X
 SG_ Pos_Estimate : 0|32@1- (1,0) [0|0] "rev" Y
 SG_ Vel_Estimate : 32|32@1- (1,0) [0|0] "rev/s" Y

BO_ 106 Counted: 8 X
 SG_ Shadow_Count : 0|32@1+ (1,0) [0|0] "counts" Y
 SG_ Count_in_CPR : 32|32@1+ (1,0) [0|0] "counts" Y

SIG_VALTYPE_ 6 Turns : 1;
SIG_VALTYPE_ 105 Pos_Estimate : 1;
SIG_VALTYPE_ 105 Vel_Estimate : 1;
"""


@fixture(scope="module")
def file(tmp_path_factory: Any) -> str:
    path: Path = tmp_path_factory.mktemp("dbc") / "controller.dbc"
    path.write_text(CONTROLLER)
    return str(path)


def wheel(file: str, position: str, unit: Any, role: WheelRole = ROLE, **more: Any) -> DbcWheel:
    return DbcWheel(role, DbcWheel.Settings(file, position, unit, **more))


def counter(file: str, **more: Any) -> DbcWheel:
    return wheel(file, "Encoder.Count", "counts", counts_per_turn=1000.0, **more)


def encoder(stamp_ns: int, count: int, backwards: int = 0) -> CanFrame:
    return CanFrame(5, pack(">H", count % (1 << 16)) + pack("<i", backwards), stamp_ns=stamp_ns)


def motion(stamp_ns: int, turns: float, tenths_rpm: int = 0) -> CanFrame:
    return CanFrame(6, pack("<fhxx", turns, tenths_rpm), stamp_ns=stamp_ns)


def readings(device: DbcWheel, *frames: CanFrame) -> list[WheelReading]:
    given = [reading for frame in frames for reading in device.step(frame.stamp_ns, [frame]).readings]
    return [reading for reading in given if isinstance(reading, WheelReading)]


@given(start=integers(0, 65535), steps=lists(integers(-150, 150), min_size=1, max_size=300))
def test_a_narrow_counter_wraps_either_way_without_a_jump(file: str, start: int, steps: list[int]) -> None:
    total, frames = start, [encoder(0, start)]
    for n, step in enumerate(steps, 1):
        total += step
        frames.append(encoder(n * 10 * MS, total))
    given = readings(counter(file), *frames)
    assert given[-1].angle - given[0].angle == approx((total - start) / 1000 * tau, abs=1e-9)
    assert not any(reading.discontinuity for reading in given)


def test_a_counter_that_uses_fewer_bits_than_its_signal_wraps_at_those(file: str) -> None:
    given = readings(counter(file, width=12), encoder(0, 4090), encoder(10 * MS, 4), encoder(20 * MS, 4090))
    assert [r.angle - given[0].angle for r in given] == approx([0.0, 10 / 1000 * tau, 0.0])


@mark.parametrize(("gear", "direction"), [(2.0, -1.0), (-2.0, 1.0)])
def test_a_factor_below_zero_turns_the_wheel_the_other_way(file: str, gear: float, direction: float) -> None:
    device = wheel(file, "Encoder.Backwards", "rad", WheelRole("left", gear, 100.0))
    first, second = readings(device, encoder(0, 0, 100), encoder(100 * MS, 0, 1100))
    assert second.angle - first.angle == approx(direction * 0.5)
    assert second.rate == approx(direction * 5.0)


def test_a_float_is_read_as_it_is(file: str) -> None:
    given = readings(wheel(file, "Motion.Turns", "turns"), motion(0, -1.5), motion(10 * MS, -1.25))
    assert [r.angle for r in given] == approx([-1.5 * tau, -1.25 * tau], abs=1e-6)


def test_the_scale_is_the_users(file: str) -> None:
    device = wheel(file, "Motion.Turns", "turns", scale=1 / 360)
    assert [r.angle for r in readings(device, motion(0, 90.0))] == approx([tau / 4])


@mark.parametrize(("signed", "tenths_rpm"), [(None, 600), (True, 600), (True, -600)])
def test_the_velocity_is_told_with_the_sign_it_has(file: str, signed: bool | None, tenths_rpm: int) -> None:
    more = {"velocity": "Motion.Rpm", "velocity_scale": 1 / 60, "velocity_signed": signed}
    (reading,) = readings(wheel(file, "Motion.Turns", "turns", **more), motion(0, 1.0, tenths_rpm))
    assert reading.rate == approx(tenths_rpm / 600 * tau)


def test_a_velocity_whose_sign_the_file_has_wrong_is_not_believed(file: str) -> None:
    more = {"velocity": "Motion.Rpm", "velocity_scale": 1 / 60 * 100}
    device = wheel(file, "Motion.Turns", "turns", **more)
    given = readings(device, motion(0, 1.0, -1), motion(100 * MS, 0.9, -1))
    assert given[-1].rate == approx(-tau, rel=1e-4)


def test_the_velocity_may_come_in_another_frame(file: str) -> None:
    more = {"velocity": "Motion.Rpm", "velocity_scale": 1000 / 60}
    (reading,) = readings(counter(file, **more), motion(0, 0.0, 600), encoder(1 * MS, 5))
    assert reading.rate == approx(tau)


def test_an_old_velocity_is_none(file: str) -> None:
    more = {"velocity": "Motion.Rpm", "velocity_scale": 1000 / 60}
    (reading,) = readings(counter(file, **more), motion(0, 0.0, 600), encoder(501 * MS, 5))
    assert reading.rate == 0.0


def test_a_restart_in_silence_is_no_motion_and_flagged(file: str) -> None:
    given = readings(counter(file), encoder(0, 20_000), encoder(1000 * MS, 3), encoder(1010 * MS, 13))
    assert [r.discontinuity for r in given] == [False, True, False]
    assert given[2].angle - given[0].angle == approx(10 / 1000 * tau)


def test_a_pause_in_which_the_counter_could_go_round_is_flagged(file: str) -> None:
    given = readings(counter(file), encoder(0, 20_000), encoder(3000 * MS, 30_000))
    assert [(r.angle - given[0].angle, r.discontinuity) for r in given] == [(0.0, False), (0.0, True)]


@mark.parametrize(
    ("frame", "name"),
    [
        (CanFrame(5, bytes(5), stamp_ns=1), "short frames"),
        (CanFrame(5, b"", remote=True, stamp_ns=1), "other frames"),
        (CanFrame(5, bytes(6), extended=True, stamp_ns=1), "other frames"),
        (CanFrame(4, bytes(6), stamp_ns=1), "other frames"),
    ],
)
def test_frames_that_tell_nothing_are_counted(file: str, frame: CanFrame, name: str) -> None:
    device = counter(file)
    assert readings(device, frame) == []
    assert device.health(1).counts[name] == 1


def test_a_position_that_is_no_number_is_counted_and_told(file: str) -> None:
    device = wheel(file, "Motion.Turns", "turns")
    assert readings(device, motion(1, nan), motion(2, 3e38)) == []
    health = device.health(3)
    assert (health.state, health.counts["no numbers"]) == (State.FAULTY, 2)


def test_health_tells_silence_short_frames_nonsense_and_turning(file: str) -> None:
    device = wheel(file, "Encoder.Count", "counts", WheelRole("left", fastest=1.0), counts_per_turn=1000.0)
    assert device.health(0).state is State.SILENT
    assert "no frame 0x5 (Encoder.Count)" in device.health(0).message
    readings(device, CanFrame(5, bytes(2), stamp_ns=1))
    assert (device.health(2).state, "6 bytes" in device.health(2).message) == (State.WRONG_DEVICE, True)
    readings(device, encoder(3, 7))
    assert device.health(4).state is State.WELL
    readings(device, *(encoder(n * 10 * MS, n * 20_011) for n in range(1, 80)))
    assert device.health(790 * MS).state is State.FAULTY
    device.lost(800 * MS)
    assert device.health(800 * MS).state is State.SILENT


def test_it_sends_nothing_and_waits_for_nothing(file: str) -> None:
    step = counter(file).step(0, [encoder(1, 0)])
    assert (step.send, step.deadline_ns) == ((), NEVER_NS)


@mark.parametrize(
    ("settings", "words"),
    [
        ({"unit": "counts"}, "counts_per_turn is 0.0: expected 0.001 to"),
        ({"unit": "turns", "counts_per_turn": 5.0}, "counts_per_turn is 5.0, but unit is"),
        ({"position": "Count"}, "position is 'Count': expected \"Message.Signal\""),
        ({"position": ""}, "position is '': expected"),
        ({"velocity": "a.b.c"}, "velocity is 'a.b.c': expected"),
        ({"scale": 0.0}, "scale is 0.0: expected"),
        ({"velocity_scale": nan}, "velocity_scale is nan: expected"),
        ({"width": 65}, "width is 65: expected 0 to 64"),
    ],
)
def test_impossible_settings_are_refused_by_name(settings: dict[str, Any], words: str) -> None:
    with raises(ValueError) as caught:
        DbcWheel.Settings(**{"file": "x", "position": "A.B", "unit": "turns", **settings})
    assert str(caught.value).startswith(words)


@mark.parametrize(
    ("settings", "words"),
    [
        ({"width": 17}, "width is 17: Encoder.Count has 16 bits"),
        ({"position": "Motion.Turns", "width": 16}, "width is 16, but Motion.Turns is a float"),
        ({"scale": 1e9}, r"a step of Encoder.Count is 1e\+06 turns: is its scale right\?"),
        ({"velocity": "Motion.None"}, "no Motion signal 'None'"),
    ],
)
def test_settings_that_do_not_fit_the_file_are_refused(
    file: str, settings: dict[str, Any], words: str
) -> None:
    base = {"file": file, "position": "Encoder.Count", "unit": "counts", "counts_per_turn": 1000.0}
    with raises(ValueError, match=words):
        DbcWheel(ROLE, DbcWheel.Settings(**{**base, **settings}))


@mark.parametrize(
    ("position", "unit", "more"),
    [
        ("Heard.Pos_Estimate", "turns", {"velocity": "Heard.Vel_Estimate"}),
        ("Counted.Shadow_Count", "counts", {"counts_per_turn": 4096.0}),
        ("Counted.Count_in_CPR", "counts", {"counts_per_turn": 4096.0, "width": 12}),
    ],
)
def test_an_emulated_controller_is_read_by_its_file_alone(
    file: str, position: str, unit: str, more: dict[str, Any]
) -> None:
    def angle(now_ns: int) -> float:
        return -9.0 * now_ns / SECOND

    node = ODriveAxis("wheel", angle, Random(1), ODriveOptions(node=3, counts_per_turn=4096))
    bus = CanBus("can", 500_000, [node])
    bus.switch_on(0)
    device = wheel(file, position, unit, **more)
    bus.take(SECOND)
    given = readings(device, *bus.take(20 * SECOND))
    assert len(given) == approx(1900, abs=2)
    for old, new in pairwise(given):
        assert new.angle - old.angle == approx(angle(new.stamp_ns) - angle(old.stamp_ns), abs=0.01)
        assert new.rate == approx(-9.0, rel=0.1)
    assert given[-1].angle - given[0].angle == approx(
        angle(given[-1].stamp_ns) - angle(given[0].stamp_ns), abs=0.01
    )
    assert device.health(20 * SECOND).state is State.WELL


@mark.parametrize("position", ["Encoder.Count", "Encoder.Backwards", "Motion.Turns"])
def test_random_frames_raise_nothing_and_turn_no_wheel_faster_than_it_can(file: str, position: str) -> None:
    random, now_ns = Random(3), SECOND
    device = wheel(file, position, "rad", velocity="Motion.Rpm", scale=0.01)
    given: list[WheelReading] = []
    for _ in range(20_000):
        now_ns += random.choice((0, random.randrange(20 * MS), random.randrange(700 * MS)))
        data = random.randbytes(random.choice((8, 8, 8, 6, random.randrange(9))))
        frame = CanFrame(random.choice((5, 6, 7)), data, False, random.random() < 0.05, now_ns)
        given += readings(device, frame)
        assert device.health(now_ns).message
    assert len(given) > 50
    for old, new in pairwise(given):
        assert isfinite(new.angle)
        reach = 0.0 if new.discontinuity else 100.0 * ((new.stamp_ns - old.stamp_ns) * 1e-9 + 0.02)
        assert abs(new.angle - old.angle) <= reach + 1e-3
