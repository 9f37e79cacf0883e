import pytest

from echogrid.drivers.bus import CanFrame
from echogrid.emulation.wires.slcan import SlcanAdapter, decode, encode

OPENING = b"C\rS6\r\rO\rO\r"
GOLDEN = [
    (CanFrame(0x001, bytes.fromhex("AABB")), "t0012AABB"),
    (CanFrame(0x981, bytes.fromhex("0000138800640032"), extended=True), "T0000098180000138800640032"),
    (CanFrame(0x069, b"", remote=True), "r0690"),
    (CanFrame(0x069, b"", extended=True, remote=True), "R000000690"),
]


def opened(bit_rate: int = 500_000) -> SlcanAdapter:
    adapter = SlcanAdapter(bit_rate)
    assert adapter.receive(OPENING) == ([], b"\r" * 5)
    return adapter


@pytest.mark.parametrize(("frame", "line"), GOLDEN)
def test_frames_and_lines_are_one_to_one(frame: CanFrame, line: str) -> None:
    assert encode(frame) == line.encode() + b"\r"
    assert decode(line) == frame


def test_lower_case_and_the_length_of_a_request_are_accepted() -> None:
    assert decode("t001aabb") is None
    assert decode("t0012aabb") == GOLDEN[0][0]
    assert decode("r0698") == GOLDEN[2][0]


@pytest.mark.parametrize("line", ["t0012AA", "t0019", "t8000", "T200000000", "t00x0", "X", "S9", "S6 "])
def test_a_malformed_line_is_answered_with_a_bell(line: str) -> None:
    assert opened().receive(line.encode() + b"\r") == ([], b"\a")


def test_a_line_may_come_in_pieces() -> None:
    adapter = opened()
    assert adapter.receive(b"t0012A") == ([], b"")
    assert adapter.receive(b"ABB\r") == ([GOLDEN[0][0]], b"\r")


def test_a_line_without_an_end_is_not_kept() -> None:
    adapter = opened()
    adapter.receive(b"t" * 100_000)
    assert adapter.receive(b"\rt0012AABB\r") == ([GOLDEN[0][0]], b"\a\r")


def test_a_closed_channel_neither_sends_nor_hears() -> None:
    adapter = opened()
    assert adapter.receive(b"C\rt0012AABB\r") == ([], b"\r\a")
    assert adapter.line(GOLDEN[0][0]) == b""


def test_the_bit_rate_is_chosen_before_opening() -> None:
    assert SlcanAdapter(500_000).receive(b"O\r") == ([], b"\a")
    assert opened().receive(b"S6\r") == ([], b"\a")


def test_at_another_bit_rate_than_the_bus_it_neither_sends_nor_hears() -> None:
    adapter = opened(bit_rate=250_000)
    assert adapter.receive(b"t0012AABB\r") == ([], b"\r")
    assert adapter.line(GOLDEN[0][0]) == b""
