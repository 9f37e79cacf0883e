from hypothesis import given
from hypothesis.strategies import binary, integers

from echogrid.emulation.devices.collision import collided


@given(binary(max_size=8), integers(10, 12))
def test_alone_nothing_is_changed(data: bytes, bits: int) -> None:
    assert collided(data, b"", 0, bits) == collided(b"", data, 0, bits) == data


@given(binary(min_size=4, max_size=4), binary(min_size=4, max_size=4))
def test_at_the_very_same_time_ones_are_pulled_down(first: bytes, second: bytes) -> None:
    both = bytes(a & b for a, b in zip(first, second, strict=True))
    assert collided(first, second, 0, 10) == both


@given(binary(max_size=4), binary(max_size=4), integers(0, 40))
def test_one_after_the_other_nothing_is_lost(first: bytes, second: bytes, gap: int) -> None:
    assert collided(first, second, 10 * len(first) + gap, 10) == first + second


def test_a_few_bits_later_the_bytes_are_others_and_one_more() -> None:
    assert collided(b"\xff\xff", b"\x00\x00", 4, 10) == b"\x07\x04\xfc"


@given(binary(min_size=1, max_size=8), binary(min_size=1, max_size=8), integers(0, 12))
def test_whatever_collides_something_is_heard(first: bytes, second: bytes, later: int) -> None:
    assert 1 <= len(collided(first, second, later, 10)) <= len(first) + len(second)
