from math import nan, pi, radians
from pathlib import Path
from random import Random
from re import escape
from struct import pack
from typing import Any

from hypothesis import given
from hypothesis import strategies as st
from pytest import approx, fixture, importorskip, mark, raises

from echogrid.drivers.bus import CanFrame
from echogrid.drivers.device import State
from echogrid.drivers.gyro_dbc import GyroDbc
from echogrid.drivers.readings import GyroReading
from echogrid.drivers.role import GyroRole

cantools = importorskip("cantools", reason="cantools is not installed")

MS = 1_000_000
SECOND = 1000 * MS
ROLE = GyroRole("gyro")
GYROS = """VERSION ""

BO_ 416 Gyro: 4 X
 SG_ Yaw_Rate : 0|16@1- (0.01,0) [0|0] "deg/s" Y
 SG_ Count : 16|8@1+ (1,0) [0|0] "" Y

BO_ 2566844926 Imu: 8 X
 SG_ Pitch_Rate : 7|16@0+ (0.0078125,-250) [0|0] "deg/s" Y
 SG_ Turn : 23|16@0+ (0.0078125,-250) [0|0] "deg/s" Y

BO_ 417 Fine: 8 X
 SG_ Omega : 0|32@1- (1,0) [0|0] "rad/s" Y

SIG_VALTYPE_ 417 Omega : 1;
"""


@fixture(scope="module")
def file(tmp_path_factory: Any) -> str:
    path: Path = tmp_path_factory.mktemp("dbc") / "gyro.dbc"
    path.write_text(GYROS)
    return str(path)


def gyro(file: str, rate: str = "Gyro.Yaw_Rate", **more: Any) -> GyroDbc:
    return GyroDbc(ROLE, GyroDbc.Settings(file=file, rate=rate, **more))


def rates(device: GyroDbc, *frames: CanFrame) -> list[float]:
    told = device.step(SECOND, frames).readings
    return [each.rate for each in told if isinstance(each, GyroReading)]


def frame(data: bytes, stamp_ns: int = 0, identifier: int = 0x1A0, extended: bool = False) -> CanFrame:
    return CanFrame(identifier, data, extended, stamp_ns=stamp_ns)


@mark.parametrize(
    ("data", "settings", "rate"),
    [
        ("E8030000", {}, radians(10.0)),
        ("18FC0000", {}, radians(-10.0)),
        ("E8030000", {"scale": -1.0}, radians(-10.0)),
        ("E8030000", {"unit": "rad/s"}, 10.0),
        ("18FC0000", {"signed": False, "fastest_dps": 1000.0}, radians(645.36)),
        ("FF7F0000", {"fastest_dps": 300.0}, None),
        ("E803", {}, None),
    ],
)
def test_a_frame_is_a_rate(file: str, data: str, settings: dict[str, Any], rate: float | None) -> None:
    told = rates(gyro(file, **settings), frame(bytes.fromhex(data)))
    assert told == ([] if rate is None else [approx(rate)])


@given(st.integers(0, 0xFFFF), st.integers(0, 0xFFFF))
def test_a_rate_is_the_number_that_cantools_finds(file: str, pitch: int, turn: int) -> None:
    data = pack(">HHI", pitch, turn, 0)
    known = cantools.database.load_file(file).decode_message("Imu", data)["Turn"]
    told = rates(gyro(file, "Imu.Turn"), frame(data, 0, 0x18FEF1FE, True))
    assert told == [approx(radians(known), abs=1e-12)]


def test_a_float_that_is_no_number_is_no_rate(file: str) -> None:
    device = gyro(file, "Fine.Omega", unit="rad/s")
    assert rates(device, frame(pack("<fI", nan, 0), 0, 0x1A1)) == []
    assert rates(device, frame(pack("<fI", pi, 0), 0, 0x1A1)) == [approx(pi)]
    assert device.health(SECOND).counts["no numbers"] == 1


def test_the_stamp_is_the_frame_s_own_less_the_lag(file: str) -> None:
    device = gyro(file, lag_ms=3.0)
    told = device.step(SECOND, [frame(bytes(4), 900 * MS), frame(bytes(4))]).readings
    assert [each.stamp_ns for each in told] == [897 * MS, 997 * MS]


def test_frames_of_others_are_not_its_own(file: str) -> None:
    device = gyro(file)
    foreign = [
        frame(bytes(4), extended=True),
        frame(bytes(4), identifier=0x1A1),
        CanFrame(0x1A0, bytes(4), remote=True),
    ]
    assert rates(device, *foreign) == []
    assert device.health(SECOND).counts["other frames"] == 3


def test_each_trouble_has_its_state(file: str) -> None:
    device = gyro(file, fastest_dps=300.0)
    assert device.health(0).state is State.SILENT
    assert "0x1a0 (Gyro.Yaw_Rate)" in device.health(0).message
    device.step(SECOND, [frame(bytes(3))])
    assert device.health(SECOND).state is State.WRONG_DEVICE
    device.step(SECOND, [frame(bytes(4))])
    assert device.health(SECOND).state is State.WELL
    device.step(2 * SECOND, [frame(b"\xff\x7f\x00\x00")])
    assert device.health(2 * SECOND).state is State.FAULTY
    device.lost(2 * SECOND)
    assert device.health(2 * SECOND).state is State.SILENT


@mark.parametrize(
    ("rate", "told"),
    [
        ("Yaw_Rate", 'expected "Message.Signal"'),
        ("Gyro.Yaw_Rat", "did you mean 'Yaw_Rate'?"),
        ("Gyros.Yaw_Rate", "did you mean 'Gyro'?"),
    ],
)
def test_a_signal_that_is_not_there_is_told(file: str, rate: str, told: str) -> None:
    with raises(ValueError, match=escape(told)):
        gyro(file, rate)


def test_a_hundred_thousand_frames_of_noise_give_no_rate_that_cannot_be(file: str) -> None:
    random, device, told = Random(1), gyro(file, "Fine.Omega", unit="rad/s", fastest_dps=500.0), 0
    for number in range(100_000):
        data = (
            random.randbytes(random.randrange(9)) if random.random() < 0.5 else pack("<fI", random.gauss(), 0)
        )
        frames = [frame(data, 0, random.choice((0x1A0, 0x1A1)), random.random() < 0.1)]
        for reading in device.step(number * MS, frames).readings:
            assert isinstance(reading, GyroReading)
            assert abs(reading.rate) <= radians(500.0)
            told += 1
    assert told > 10_000
