"""The kernel's answers about its links: packed here by its header files, and by this machine's kernel."""

import socket
from struct import pack

from hypothesis import given
from hypothesis import strategies as st
from pytest import mark

from echogrid.drivers.transports.can_link import BusState, CanLink, parse, read_link, request


def attribute(kind: int, content: bytes) -> bytes:
    return pack("=HH", 4 + len(content), kind) + content + bytes(-len(content) % 4)


def answer(flags: int, *attributes: bytes) -> bytes:
    body = pack("=BBHiII", socket.AF_UNSPEC, 0, 280, 7, flags, 0) + b"".join(attributes)
    return pack("=IHHII", 16 + len(body), 16, 0, 1, 4321) + body


STATISTICS = [1000 + number for number in range(24)]
CAN0 = answer(
    0x1 | 0x40 | 0x80,
    attribute(3, b"can0\0"),
    attribute(23, pack("=24Q", *STATISTICS)),
    attribute(
        18 | 0x8000,
        attribute(1, b"can\0")
        + attribute(
            2,
            attribute(8, pack("=HH", 136, 5))
            + attribute(1, pack("=8I", 500_000, 875, 125, 6, 7, 2, 1, 1))
            + attribute(4, pack("=I", 2))
            + attribute(6, pack("=I", 100)),
        )
        + attribute(3, pack("=6I", 11, 12, 13, 14, 15, 16)),
    ),
)


def test_a_can_interface_is_read() -> None:
    assert parse(CAN0) == CanLink(
        7,
        True,
        "can",
        500_000,
        100,
        BusState.ERROR_PASSIVE,
        (136, 5),
        {
            "bus errors": 11,
            "error warnings": 12,
            "error passives": 13,
            "bus-offs": 14,
            "arbitrations lost": 15,
            "restarts": 16,
            "overruns": 1006 + 1011,
        },
    )


def test_what_is_not_told_is_not_known() -> None:
    virtual = answer(0, attribute(18, attribute(1, b"vcan\0")))
    assert parse(virtual) == CanLink(7, False, "vcan")


def test_a_state_that_is_not_known_is_none() -> None:
    link = parse(answer(1, attribute(18, attribute(2, attribute(4, pack("=I", 99))))))
    assert link == CanLink(7, True)


def test_an_error_is_no_link() -> None:
    assert parse(pack("=IHHIIi", 36, 2, 0, 1, 0, -19) + bytes(16)) is None


@mark.parametrize("length", range(0, len(CAN0), 3))
def test_an_answer_that_is_cut_short_never_raises(length: int) -> None:
    parse(CAN0[:length])


@given(st.binary(max_size=300), st.integers(16, len(CAN0)))
def test_noise_never_raises(noise: bytes, at: int) -> None:
    parse(noise)
    parse(CAN0[:at] + noise)


def test_the_question_names_the_interface() -> None:
    assert request("can0") == (
        bytes.fromhex("2c000000 1200 0100 01000000 00000000")
        + bytes(16)
        + bytes.fromhex("0900 0300")
        + b"can0\0\0\0\0"
    )


def test_this_kernel_tells_its_loopback() -> None:
    link = read_link("lo")
    assert link is not None
    assert link.index == socket.if_nametoindex("lo")
    assert (link.bitrate, link.state) == (None, None)


def test_this_kernel_has_no_interface_of_another_name() -> None:
    assert read_link("nosuchcan0") is None


def test_an_interface_with_can_fd_is_read() -> None:
    timing = attribute(1, pack("=8I", 1_000_000, 666, 1, 1, 1, 1, 1, 1)) + attribute(
        9, pack("=8I", 5_000_000, 666, 1, 1, 1, 1, 1, 1)
    )
    link = parse(answer(1, attribute(4, pack("=I", 72)), attribute(18, attribute(2, timing))))
    assert link == CanLink(7, True, bitrate=1_000_000, mtu=72, data_bitrate=5_000_000)
