from itertools import pairwise

from hypothesis import given
from hypothesis.strategies import binary, integers, lists

from echogrid.drivers.ff_frame import LONGEST_MM, FrameFinder, decode

CODES = frozenset({0, 0xFFFD, 0xFFFE})
DISTANCES = integers(0, LONGEST_MM)


def encode(millimetres: int) -> bytes:
    body = b"\xff" + millimetres.to_bytes(2, "big")
    return body + bytes([sum(body) % 256])


def found(finder: FrameFinder, chunk: bytes) -> list[int]:
    return [frame.millimetres for frame in finder.feed(chunk)]


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


@given(integers(0, 0xFFFF))
def test_every_distance_survives_the_frame(millimetres: int) -> None:
    assert decode(encode(millimetres)) == millimetres


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
def test_frames_are_found_however_the_stream_is_cut(distances: list[int], cuts: list[int]) -> None:
    stream = b"".join(map(encode, distances))
    places = [0, *sorted(min(cut, len(stream)) for cut in cuts), len(stream)]
    finder = FrameFinder(CODES)
    values = [v for a, b in pairwise(places) for v in found(finder, stream[a:b])]
    assert values == distances


@given(binary(max_size=200))
def test_garbage_yields_only_possible_distances_and_every_byte_is_accounted_for(garbage: bytes) -> None:
    finder = FrameFinder(CODES)
    values = found(finder, garbage)
    assert all(value <= LONGEST_MM or value in CODES for value in values)
    assert 0 <= len(garbage) - 4 * len(values) - finder.skipped_bytes <= 3


@given(binary(max_size=50), integers(1, LONGEST_MM))
def test_a_steady_distance_is_found_within_three_frames_after_garbage(garbage: bytes, distance: int) -> None:
    finder = FrameFinder(CODES)
    found(finder, garbage)
    found(finder, encode(distance) * 3)
    assert found(finder, encode(distance)) == [distance]


def test_a_steady_distance_taken_up_at_its_last_byte_is_not_misread() -> None:
    stream = (encode(511) * 5)[3:]
    assert found(FrameFinder(CODES), stream) == [511] * 4


@given(binary(min_size=1, max_size=1).filter(lambda byte: byte != b"\xff"))
def test_the_frame_behind_noise_does_not_adjoin_but_the_next_does(noise: bytes) -> None:
    finder = FrameFinder(CODES)
    frames = list(finder.feed(encode(500) + encode(501) + noise + encode(502) + encode(503)))
    assert [frame.adjoining for frame in frames] == [False, True, False, True]


def test_a_false_header_costs_one_byte_only() -> None:
    finder = FrameFinder(CODES)
    assert found(finder, b"\xff" + encode(1953)) == [1953]
    assert (finder.false_headers, finder.skipped_bytes) == (1, 1)


def test_after_forgetting_half_a_frame_the_next_is_whole() -> None:
    finder = FrameFinder(CODES)
    found(finder, encode(1953)[:3])
    finder.forget()
    assert found(finder, encode(1717)) == [1717]
