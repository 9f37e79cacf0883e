from errno import EIO, ETIMEDOUT

from hypothesis import given
from hypothesis.strategies import binary, integers, sampled_from
from pytest import mark

from echogrid.drivers.bus import IioRead, Result
from echogrid.drivers.iio_kernel import (
    KERNEL_DRIVERS,
    MAXBOTIX,
    NUMBER,
    PING,
    SRF,
    SRF04,
    failure_of,
    kernel_driver,
    raw_of,
    scale_of,
    told,
)

MS = 1_000_000
RAW = IioRead("front", "in_distance_raw")


def read(data: bytes = b"", errno: int = 0, after_ms: float = 10.0) -> Result[IioRead]:
    return Result(RAW, 5 * MS, 5 * MS + round(after_ms * MS), data, errno)


@mark.parametrize(
    ("name", "known"),
    [
        ("srf04\n", SRF04),
        ("ping\n", PING),
        ("srf08\n", SRF),
        ("maxbotix-mb1232\n", MAXBOTIX),
        ("mb7137\n", MAXBOTIX),
        ("bme280\n", None),
        ("vl53l0x\n", None),
        ("\ufffd", None),
        ("", None),
    ],
)
def test_a_kernel_driver_is_known_by_its_name(name: str, known: object) -> None:
    assert kernel_driver(name) is known


def test_the_texts_of_the_kernel_are_understood() -> None:
    assert scale_of(b"0.001000\n") == 0.001
    assert scale_of(b"0.010000\n") == 0.01
    assert raw_of(told(read(b"1501\n"))) == 1501
    assert raw_of(told(read(b"-22\n"))) == -22


@mark.parametrize("text", [b"", b"\n", b"1.5", b"0x10", b"1 2", b"1_0", b"\xd9\xa1", b"9" * 11])
def test_what_is_no_number_is_none(text: bytes) -> None:
    assert raw_of(text) is None


@mark.parametrize("text", [b"", b"0.000000\n", b"1", b"-0.001000\n", b"nan\n", b"1e3\n"])
def test_what_is_no_scale_is_none(text: bytes) -> None:
    assert scale_of(text) is None


def test_a_failed_read_tells_why_and_when() -> None:
    data = told(read(errno=ETIMEDOUT, after_ms=20.4))
    failure = failure_of(data)
    assert data == b"ETIMEDOUT after 20 ms"
    assert failure and failure.without_pulse and not failure.with_endless_pulse


@mark.parametrize("after_ms", [40.0, 50.5, 70.0])
def test_a_late_time_out_is_a_pulse_without_an_end(after_ms: float) -> None:
    failure = failure_of(told(read(errno=ETIMEDOUT, after_ms=after_ms)))
    assert failure and failure.with_endless_pulse and not failure.without_pulse


def test_other_failures_are_told_by_name() -> None:
    failure = failure_of(told(read(errno=EIO)))
    assert failure and failure.name == "EIO"
    assert not failure.without_pulse
    assert not failure.with_endless_pulse
    assert told(read(errno=9999)) == b"UNKNOWN after 10 ms"


@given(binary(max_size=30))
def test_whatever_a_file_says_it_is_a_number_or_none(data: bytes) -> None:
    raw = raw_of(data)
    assert (raw is not None) == bool(NUMBER.fullmatch(data))
    assert scale_of(data) is None or scale_of(data) > 0  # type: ignore[operator]  # it is a number then
    assert failure_of(data) is None or b" after " in data


@given(sampled_from(sorted(KERNEL_DRIVERS)), integers(0, 100_000))
def test_a_number_is_never_taken_for_a_failure(name: str, raw: int) -> None:
    assert failure_of(str(raw).encode()) is None
    assert KERNEL_DRIVERS[name].speed_of_sound > 340


def test_the_longest_pulse_of_each_driver_is_its_largest_value() -> None:
    assert SRF04.most_raw == 40_438_871 * 106 // 617_176
    assert PING.most_raw == 18_500_000 * 232 // 1_350_800
