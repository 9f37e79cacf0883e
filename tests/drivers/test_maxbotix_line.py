from itertools import pairwise

from hypothesis import given
from hypothesis.strategies import binary, integers, lists, sampled_from, text
from pytest import mark

from echogrid.drivers.maxbotix_line import LineFinder

GREETING = b"HRXL-MaxSonar-WRL\rPN:MB7386\rCopyright 2011-2013\rMaxBotix Inc.\rRoHS 1.8b090  0713\rTempI\r"
"""What an HRXL says at power-up (EnviroDIY/ModularSensors, MaxBotixSonar.cpp)."""
TAILS = sampled_from([b"\r", b" \r", b" P0\r", b" P1\r"])


def numbers(finder: LineFinder, chunk: bytes) -> list[int]:
    return [number for number, _, _ in finder.feed(chunk)]


@mark.parametrize(
    ("line", "number", "present"),
    [
        (b"R040\r", 40, None),
        (b"R255\r", 255, None),
        (b"R008 P1\r", 8, True),
        (b"R008 P0\r", 8, False),
        (b"R012\r", 12, None),
    ],
)
def test_the_lines_of_three_digits_are_read(line: bytes, number: int, present: bool | None) -> None:
    assert LineFinder(3).feed(line) == [(number, line, present)]


@mark.parametrize(("line", "number"), [(b"R0480 \r", 480), (b"R2257\r", 2257), (b"R1478\r", 1478)])
def test_the_lines_of_four_digits_are_read(line: bytes, number: int) -> None:
    assert LineFinder(4).feed(line) == [(number, line, None)]


@mark.parametrize(
    "line",
    [b"R04\r", b"R0400\r", b"R04O\r", b"040\r", b"r040\r", b"R 040\r", b"R040", b"R040\n", b"R040 P2\r"],
)
def test_a_line_with_a_digit_more_or_less_or_wrong_is_none(line: bytes) -> None:
    assert LineFinder(3).feed(line) == []


def test_the_text_at_power_up_is_passed_over() -> None:
    """As captured by open-storm/perfect-cell: text, TempI, and two lines."""
    finder = LineFinder(4)
    assert numbers(finder, GREETING + b"R1478\rR1477\r") == [1478, 1477]
    assert (finder.bad_lines, finder.skipped_bytes) == (6, len(GREETING))


@given(lists(integers(0, 999), max_size=8), TAILS, lists(integers(0, 60), max_size=6))
def test_lines_are_found_however_the_stream_is_cut(sent: list[int], tail: bytes, cuts: list[int]) -> None:
    stream = b"".join(b"R%03d" % number + tail for number in sent)
    places = [0, *sorted(min(cut, len(stream)) for cut in cuts), len(stream)]
    finder = LineFinder(3)
    assert [n for a, b in pairwise(places) for n in numbers(finder, stream[a:b])] == sent
    assert (finder.bad_lines, finder.skipped_bytes) == (0, 0)


@given(binary(max_size=60) | text("R0123456789 P\r", max_size=60).map(str.encode), integers(0, 9999), TAILS)
def test_the_first_whole_line_behind_any_noise_is_found(noise: bytes, number: int, tail: bytes) -> None:
    finder = LineFinder(4)
    finder.feed(noise)
    line = b"R%04d" % number + tail
    assert finder.feed(line)[-1][:2] == (number, line)


@given(integers(0, 999), integers(0, 4), integers(0, 2))
def test_a_lost_byte_never_makes_another_number(number: int, place: int, before: int) -> None:
    line = b"R%03d\r" % number
    stream = line * before + line[:place] + line[place + 1 :] + line
    assert numbers(LineFinder(3), stream) == [number] * (before + 1)


@given(binary(max_size=300))
def test_every_byte_of_noise_is_accounted_for(noise: bytes) -> None:
    finder = LineFinder(3)
    read = sum(len(raw) for _, raw, _ in finder.feed(noise))
    assert 0 <= len(noise) - read - finder.skipped_bytes <= 7


def test_after_forgetting_half_a_line_the_other_half_is_no_line() -> None:
    finder = LineFinder(3)
    finder.feed(b"R0")
    finder.forget()
    assert numbers(finder, b"40\rR041\r") == [41]
