from itertools import chain, pairwise

from hypothesis import given
from hypothesis.strategies import binary, booleans, integers, lists
from pytest import mark

from echogrid.drivers.ff_frame import LONGEST_MM, FrameFinder, decode

CODES = frozenset({0, 0xFFFD, 0xFFFE})
DISTANCES = integers(0, LONGEST_MM)


def encode(millimetres: int, header_summed: bool = True) -> bytes:
    header, high, low = 0xFF, *divmod(millimetres, 256)
    return bytes([header, high, low, (header * header_summed + high + low) % 256])


def found(finder: FrameFinder, chunk: bytes) -> list[int]:
    return [millimetres for millimetres, _, _ in finder.feed(chunk)]


def believed(finder: FrameFinder, chunk: bytes) -> list[int]:
    return [millimetres for millimetres, _, adjoining in finder.feed(chunk) if adjoining]


def test_the_known_frames_are_decoded() -> None:
    known = {
        "FF 07 A1 A7": 1953,
        "FF 06 B5 BA": 1717,
        "FF 00 E0 DF": 224,
        "FF 00 00 FF": 0,
        "FF FF FD FB": 0xFFFD,
        "FF FF FE FC": 0xFFFE,
    }
    assert {text: decode(bytes.fromhex(text)) for text in known} == known


def test_on_some_boards_the_header_is_not_in_the_sum() -> None:
    """The example of ptvoinfo/zigbee-configurable-firmware#274; an AJ-SR04M in esphome/esphome#7044."""
    assert decode(bytes.fromhex("FF00DEDE"), header_summed=False) == 222
    assert decode(bytes.fromhex("FF00DEDE")) is None
    assert decode(bytes.fromhex("FF07A1A7"), header_summed=False) is None


@given(integers(0, 0xFFFF), booleans())
def test_every_distance_survives_the_frame(millimetres: int, header_summed: bool) -> None:
    assert decode(encode(millimetres, header_summed), header_summed) == millimetres


@given(integers(0, 0xFFFF), integers(0, 3), integers(1, 255))
def test_a_frame_with_one_wrong_byte_is_none(millimetres: int, place: int, flip: int) -> None:
    frame = bytearray(encode(millimetres))
    frame[place] ^= flip
    assert decode(bytes(frame)) is None


@given(binary(max_size=8))
def test_bytes_that_are_no_frame_decode_to_none_or_a_word(data: bytes) -> None:
    millimetres = decode(data)
    assert millimetres is None or 0 <= millimetres <= 0xFFFF


@given(lists(DISTANCES, max_size=10), lists(integers(0, 40), max_size=5))
def test_however_the_stream_is_cut_the_same_is_found(distances: list[int], cuts: list[int]) -> None:
    stream = b"".join(map(encode, distances))
    places = [0, *sorted(min(cut, len(stream)) for cut in cuts), len(stream)]
    finder = FrameFinder(CODES)
    cut = [frame for a, b in pairwise(places) for frame in finder.feed(stream[a:b])]
    assert cut == FrameFinder(CODES).feed(stream)
    assert set(distances) <= {millimetres for millimetres, _, _ in cut}


@given(binary(max_size=200))
def test_garbage_yields_only_possible_distances(garbage: bytes) -> None:
    finder = FrameFinder(CODES)
    values = found(finder, garbage)
    assert all(value <= LONGEST_MM or value in CODES for value in values)
    assert 0 <= finder.skipped_bytes <= len(garbage)
    assert finder.false_headers <= garbage.count(0xFF)


@given(binary(max_size=50), DISTANCES, DISTANCES)
def test_whatever_was_before_the_second_of_two_frames_is_believed(
    noise: bytes, first: int, second: int
) -> None:
    finder = FrameFinder(CODES)
    finder.feed(noise)
    finder.feed(encode(first))
    assert finder.feed(encode(second))[-1] == (second, encode(second), True)


@mark.parametrize("header_summed", [True, False])
def test_a_steady_distance_is_never_misread_wherever_it_is_taken_up(header_summed: bool) -> None:
    for distance in chain(range(LONGEST_MM + 1), CODES):
        stream = encode(distance, header_summed) * 4
        for start in (1, 2, 3):
            assert believed(FrameFinder(CODES, header_summed), stream[start:]) == [distance] * 2


def test_only_a_fall_of_1024_mm_looks_like_another_frame_in_between() -> None:
    looks_so = {
        (first, second)
        for first in range(0, LONGEST_MM, 3)
        for second in (first - 1024, first - 256, first, first + 256, first + 1024)
        if 0 <= second <= LONGEST_MM and len(FrameFinder(CODES).feed(encode(first) + encode(second))) > 2
    }
    assert {first - second for first, second in looks_so} == {1024}
    assert all(first % 256 == 255 for first, _ in looks_so)


@given(binary(min_size=1, max_size=3).filter(lambda noise: 0xFF not in noise))
def test_the_frame_behind_noise_does_not_adjoin_but_the_next_does(noise: bytes) -> None:
    finder = FrameFinder(CODES)
    frames = finder.feed(encode(500) + encode(501) + noise + encode(502) + encode(503))
    assert [adjoining for _, _, adjoining in frames] == [False, True, False, True]
    assert finder.skipped_bytes == len(noise)


def test_a_lost_byte_costs_no_more_than_the_frame_it_was_in() -> None:
    stream = encode(511) * 2 + encode(511)[:3] + encode(511) * 3
    assert believed(FrameFinder(CODES), stream)[-2:] == [511, 511]


def test_a_false_header_costs_one_byte_only() -> None:
    finder = FrameFinder(CODES)
    assert found(finder, b"\xff" + encode(1953)) == [1953]
    assert (finder.false_headers, finder.skipped_bytes) == (1, 1)


def test_a_header_within_a_frame_is_no_false_one() -> None:
    finder = FrameFinder(CODES)
    found(finder, encode(255) * 5)
    assert (finder.false_headers, finder.skipped_bytes) == (0, 0)


def test_after_forgetting_half_a_frame_the_next_is_whole_and_does_not_adjoin() -> None:
    finder = FrameFinder(CODES)
    found(finder, encode(1953) + encode(1953)[:3])
    finder.forget()
    assert finder.feed(encode(1717)) == [(1717, encode(1717), False)]
