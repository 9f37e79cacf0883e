import umodbus
from hypothesis import assume, given
from hypothesis.strategies import binary, integers, lists, sampled_from
from pytest import mark, raises
from umodbus.client.serial import rtu
from umodbus.client.serial.redundancy_check import get_crc

from echogrid.drivers.modbus import Reply, Request, quiet_ns, read, write

umodbus.conf.SIGNED_VALUES = False

DEVICES = integers(1, 247)
WORDS = integers(0, 0xFFFF)


def sealed(*body: int) -> bytes:
    """A frame by another library's checksum."""
    return bytes(body) + get_crc(bytes(body))


def told(request: Request, *registers: int) -> bytes:
    """The reply to a reading, by another library's checksum."""
    data = b"".join(register.to_bytes(2, "big") for register in registers)
    return sealed(*request.frame[:2], len(data), *data)


@mark.parametrize(
    ("device", "register", "frame"),
    [
        (0x0C, 0x05, "0C 03 00 05 00 01 95 16"),
        (0x0D, 0x05, "0D 03 00 05 00 01 94 C7"),
        (0x0B, 0x05, "0B 03 00 05 00 01 94 A1"),
        (0x0F, 0x05, "0F 03 00 05 00 01 95 25"),
        (0x50, 0x34, "50 03 00 34 00 01 C8 45"),
        (0x01, 0x100, "01 03 01 00 00 01 85 F6"),
        (0x01, 0x101, "01 03 01 01 00 01 D4 36"),
    ],
)
def test_requests_are_those_of_the_data_sheets(device: int, register: int, frame: str) -> None:
    assert read(device, register, 1).frame == bytes.fromhex(frame)


@mark.parametrize(
    ("request_", "frame", "expected"),
    [
        (read(0x0C, 5, 1), "0C 03 02 30 39 41 97", Reply((12345,))),
        (read(0x0C, 5, 1), "0C 03 02 FF FF 94 35", Reply((0xFFFF,))),
        (read(0x50, 0x34, 1), "50 03 02 07 0B 06 7F", Reply((1803,))),
        (read(0x01, 0x101, 1), "01 03 02 07 A1 7B CC", Reply((1953,))),
        (read(0x0C, 5, 1), "0C 83 02 51 32", Reply(exception=2)),
    ],
)
def test_replies_are_those_of_the_data_sheets(request_: Request, frame: str, expected: Reply) -> None:
    assert request_.reply(bytes.fromhex(frame)) == expected


@given(DEVICES, WORDS, integers(1, 125), WORDS)
def test_requests_are_those_of_another_library(device: int, register: int, count: int, value: int) -> None:
    assert read(device, register, count).frame == rtu.read_holding_registers(device, register, count)
    assert write(device, register, value).frame == rtu.write_single_register(device, register, value)


@given(DEVICES, WORDS, lists(WORDS, min_size=1, max_size=125))
def test_what_another_library_encodes_is_read(device: int, register: int, words: list[int]) -> None:
    request = read(device, register, len(words))
    frame = told(request, *words)
    assert rtu.parse_response_adu(frame, request.frame) == words
    assert request.reply(frame) == Reply(tuple(words))


@given(DEVICES, WORDS, WORDS)
def test_a_write_is_answered_by_its_repetition(device: int, register: int, value: int) -> None:
    request = write(device, register, value)
    assert request.reply(request.frame) == Reply((value,))
    other = write(device, register, value ^ 1)
    assert "to something else" in request.reply(other.frame).doubt


@mark.parametrize(
    ("code", "words"),
    [
        (1, "illegal function (Modbus exception 1)"),
        (2, "illegal address (Modbus exception 2)"),
        (6, "device busy (Modbus exception 6)"),
        (0x63, "unknown (Modbus exception 99)"),
        (0, "unknown (Modbus exception 0)"),
    ],
)
def test_a_refusal_is_told_by_its_name(code: int, words: str) -> None:
    request = read(1, 0x0100, 1)
    reply = request.reply(sealed(1, 0x83, code))
    assert (reply.exception, reply.refusal, reply.doubt, reply.registers) == (code, words, "", ())


def test_the_length_of_a_reply_is_known_from_its_second_byte_on() -> None:
    request = read(0x0C, 5, 4)
    lengths = [request.reply_length(told(request, 1, 2, 3, 4)[:count]) for count in (0, 1, 2, 13)]
    assert lengths == [0, 0, 13, 13]
    assert request.reply_length(bytes.fromhex("0C 83")) == 5
    assert write(0x0C, 8, 4).reply_length(bytes.fromhex("0C 06")) == 8


@given(integers(0, 12 * 8 - 1), sampled_from([(1, 2, 3), (0xFFFF, 0, 0x0403)]))
def test_a_flipped_bit_is_never_overlooked(bit: int, words: tuple[int, ...]) -> None:
    request = read(0x0C, 5, 3)
    frame = bytearray(told(request, *words))
    assume(bit < 8 * len(frame))
    frame[bit // 8] ^= 1 << bit % 8
    assert request.reply(bytes(frame)).doubt


@mark.parametrize(
    ("frame", "doubt"),
    [
        ("", "a reply of the wrong length (nothing)"),
        ("0C 03 02 30 39 41", "a reply of the wrong length (0c 03 02 30 39 41)"),
        ("0C 03 02 30 39 41 97 00", "a reply of the wrong length (0c 03 02 30 39 41 97 00)"),
        ("0C 03 02 30 39 41 98", "a reply with a wrong checksum (0c 03 02 30 39 41 98)"),
        ("0D 03 02 30 39 7C 57", "a reply to something else (0d 03 02 30 39 7c 57)"),
        ("0C 04 02 30 39 40 E3", "a reply to something else (0c 04 02 30 39 40 e3)"),
    ],
)
def test_what_is_no_reply_is_doubted_for_a_reason(frame: str, doubt: str) -> None:
    assert read(0x0C, 5, 1).reply(bytes.fromhex(frame)) == Reply(doubt=doubt)


def test_a_frame_inside_noise_is_not_dug_out() -> None:
    request = read(0x0C, 5, 3)
    inner = bytes.fromhex("0C 03 02 30 39 41 97")
    assert request.reply(bytes.fromhex("0C 03 01 00") + inner).doubt
    assert request.reply(inner + bytes.fromhex("00 00 00 00")).doubt
    refusal_inside = bytes.fromhex("0C 03 06 FF FF 00 00 00 03 3B 3F")
    assert "wrong checksum" in request.reply(refusal_inside).doubt


@given(binary(max_size=40), sampled_from([read(0x0C, 5, 1), read(0x0C, 5, 4), write(0x0C, 8, 12)]))
def test_no_bytes_raise_and_only_whole_frames_are_believed(heard: bytes, request: Request) -> None:
    reply = request.reply(heard)
    assert request.reply_length(heard) >= 0
    believed = len(heard) >= 4 and get_crc(heard[:-2]) == heard[-2:]
    assert reply.doubt or believed


@given(integers(1, 124), integers(1, 124))
def test_a_reply_to_another_count_is_doubted(asked: int, came: int) -> None:
    assume(asked != came)
    assert read(1, 0, asked).reply(told(read(1, 0, came), *range(came))).doubt


def test_what_cannot_be_asked_is_refused() -> None:
    for count in (0, 126):
        with raises(ValueError, match="count"):
            read(1, 0, count)


def test_the_silence_between_frames_is_3_5_characters_and_1_75_ms_above_19200_baud() -> None:
    assert quiet_ns(9600) == 4_010_416
    assert quiet_ns(19_200) == 2_005_208
    assert quiet_ns(9600, 12) == 4_375_000
    assert quiet_ns(38_400) == quiet_ns(115_200) == 1_750_000
