"""The maker's own examples, and the maker's own library."""

import math
from random import Random
from struct import pack
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pytest import approx, mark, raises

from echogrid.drivers.moteus import QUERY
from echogrid.drivers.moteus_frames import Form, Register, Value, padded, parse, read

REPLY = bytes.fromhex("2404000A005000000170FF230D181400")
"""To the example of docs/protocol/can.md."""
COMMAND = bytes.fromhex("01000A07206000200150FF140400130D")
INT32_QUERY = bytes.fromhex("11001A01110F")
INT32_REPLY = bytes.fromhex("21000A2A01F0490200599EFFFF210F00")


@pytest.fixture
def maker() -> Any:
    return pytest.importorskip("moteus", reason="the maker's library is not installed (pip install moteus)")


def test_the_example_is_read_as_the_maker_says() -> None:
    replies = parse(REPLY)
    assert replies.whole
    assert replies.number(Register.MODE) == 10
    assert replies.quantity(Register.POSITION) * 360 == approx(2.88)
    assert replies.quantity(Register.VELOCITY) * 360 == approx(23.04)
    assert replies.values[3] == Value(Form.INT16, -144)
    assert replies.quantity(Register.VOLTAGE) == 12.0
    assert replies.quantity(Register.TEMPERATURE) == 20.0
    assert replies.number(Register.FAULT) == 0


def test_a_command_tells_nothing() -> None:
    assert parse(COMMAND).values == {}
    assert parse(COMMAND).whole


def test_integers_of_32_bits_are_read_and_asked_for() -> None:
    asked = (read(Form.INT8, Register.MODE), read(Form.INT32, Register.POSITION, 2))
    assert b"".join((*asked, read(Form.INT8, Register.FAULT))) == INT32_QUERY
    replies = parse(INT32_REPLY)
    assert replies.quantity(Register.POSITION) == approx(1.5)
    assert replies.quantity(Register.VELOCITY) == approx(-0.24999)


def test_a_request_is_padded_to_a_length_that_the_bus_has() -> None:
    assert padded((b"123456789",)) == b"123456789PPP"
    assert [len(padded((bytes(count),))) for count in (0, 8, 12, 13, 63)] == [0, 8, 12, 16, 64]


def test_the_request_reads_and_nothing_else() -> None:
    assert bytes.fromhex("1100 1E01 130D 1158 1970 50 50") == QUERY


@mark.parametrize(
    ("form", "raw"), [(0, b"\x80"), (1, b"\x00\x80"), (2, b"\x00\x00\x00\x80"), (3, pack("<f", math.nan))]
)
def test_the_lowest_number_is_none(form: int, raw: bytes) -> None:
    assert math.isnan(parse(bytes((0x21 | form << 2, 1)) + raw).quantity(Register.POSITION))


def test_a_register_beyond_seven_bits_and_a_long_count_are_understood() -> None:
    assert parse(bytes.fromhex("20 04 A0 02 01 02 03 04")).values == {
        0x120 + at: Value(Form.INT8, at + 1) for at in range(4)
    }


def test_an_unknown_register_is_an_error_and_the_rest_is_read() -> None:
    replies = parse(bytes.fromhex("31 70 01 21 00 0A 30 20 02"))
    assert (replies.errors, replies.number(Register.MODE), replies.whole) == ({0x70: 1}, 10, True)


def test_streams_are_passed_over() -> None:
    stream = bytes.fromhex("40 01 02 21 00  41 01 01 FF  42 01 30  43 01 07 01 AA  44 01 07 30")
    replies = parse(stream + b"\x21\x00\x0a")
    assert (replies.values, replies.whole) == ({0: Value(Form.INT8, 10)}, True)


@mark.parametrize(
    "data",
    [
        "21",
        "2100",
        "22000A",
        "2D01000000",
        "20FFFFFFFF0F00",
        "20808080808000",
        "3170",
        "41010500",
        "51",
        "FF",
    ],
)
def test_what_is_cut_short_or_of_no_kind_is_not_whole(data: str) -> None:
    assert not parse(bytes.fromhex(data)).whole


@mark.parametrize("length", range(len(REPLY)))
def test_a_reply_that_is_cut_short_keeps_what_came_before(length: int) -> None:
    cut = parse(REPLY[:length])
    assert cut.values.items() <= parse(REPLY).values.items()


def test_a_request_is_that_of_the_makers_library(maker: Any) -> None:
    resolution = maker.QueryResolution()
    resolution.torque = maker.IGNORE
    resolution._extra = {0x058: maker.INT8, 0x070: maker.INT32}
    command = maker.Controller(id=5, query_resolution=resolution).make_query()
    assert command.data == QUERY.rstrip(b"\x50")
    assert command.reply_required


def test_the_makers_library_finds_only_reads_in_a_request(maker: Any) -> None:
    kinds = {subframe.type for subframe in maker.multiplex.parse_frame(QUERY)}
    assert kinds == {maker.multiplex.SubframeType.READ}


def subframes(random: Random) -> bytes:
    """Some of any kind that a controller may send, in one frame."""
    data = b""
    while random.random() < 0.8:
        form, count = random.randrange(4), random.randrange(1, 5)
        values = random.randbytes(count * (1, 2, 4, 4)[form])
        head = bytes((0x20 | form << 2 | count,)) if count < 4 else bytes((0x20 | form << 2, count))
        register = random.randrange(0x60)
        data += random.choice((head + bytes((register,)) + values, bytes((0x31, register, 1)), b"\x50"))
    return data


def makers(maker: Any, data: bytes) -> tuple[dict[int, float], dict[int, int]]:
    values, errors = {}, {}
    for subframe in maker.multiplex.parse_frame(data):
        if isinstance(subframe, maker.multiplex.ErrorSubframe):
            if subframe.type is maker.multiplex.SubframeType.READ_ERROR:
                errors[subframe.register] = subframe.error_code
        elif getattr(subframe, "type", None) is maker.multiplex.SubframeType.RESPONSE:
            values[subframe.register] = subframe.value
    return values, errors


@mark.parametrize("seed", range(200))
def test_what_is_whole_is_read_as_by_the_makers_library(maker: Any, seed: int) -> None:
    random = Random(seed)
    data = subframes(random) if seed % 2 else random.randbytes(random.choice((1, 4, 8, 12, 32)))
    replies = parse(data)
    if replies.whole:
        values, errors = makers(maker, data)
        assert {at: repr(value.raw) for at, value in replies.values.items()} == {
            at: repr(value) for at, value in values.items()
        }
        assert replies.errors == errors
    assert replies.whole or not seed % 2


@mark.parametrize("form", Form)
def test_quantities_are_those_of_the_makers_library(maker: Any, form: Form) -> None:
    raw = {Form.INT8: 100, Form.INT16: -12_345, Form.INT32: 123_456_789, Form.FLOAT: 1.25}[form]
    packed = pack("<" + "bhif"[form], raw)
    for register in (Register.POSITION, Register.VELOCITY, Register.VOLTAGE, Register.TEMPERATURE):
        data = bytes((0x21 | form << 2, register)) + packed
        assert parse(data).quantity(register) == approx(maker.protocol.parse_reply(data)[register])


@given(st.binary(max_size=64))
def test_any_bytes_are_parsed(data: bytes) -> None:
    replies = parse(data)
    assert len(replies.values) + len(replies.errors) <= len(data)


def test_more_than_a_frame_holds_is_refused() -> None:
    with raises(StopIteration):
        padded((bytes(65),))
