from hypothesis import given
from hypothesis import strategies as st
from pytest import mark

from echogrid.drivers import canopen
from echogrid.drivers.bus import CanFrame
from echogrid.drivers.canopen import Command, Emergency, Kind, NmtState, SdoReply
from echogrid.drivers.canopen_pdo import EACH_SYNC, Pdo, receive, transmit
from echogrid.drivers.emergency import blinds, emergency_name, is_communication, is_reset

nodes = st.integers(1, 127)
indices = st.integers(0, 0xFFFF)
subs = st.integers(0, 0xFF)


def test_the_known_frames_are_made_and_read() -> None:
    assert canopen.nmt(Command.START, 2) == CanFrame(0x000, bytes.fromhex("0102"))
    assert canopen.read_request(2, 0x6064, 0) == CanFrame(0x602, bytes.fromhex("4064600000000000"))
    reply = canopen.decode_sdo(bytes.fromhex("43646000C01DFEFF"))
    assert reply == SdoReply(Kind.READ, 0x6064, 0, bytes.fromhex("C01DFEFF"))
    emergency = canopen.decode_emergency(bytes.fromhex("1073210000000000"))
    assert emergency == Emergency(0x7310, 0x21, bytes(5))


def test_the_identifiers_are_the_standard_s() -> None:
    assert [canopen.tpdo(number, 2) for number in range(1, 5)] == [0x182, 0x282, 0x382, 0x482]
    assert [canopen.rpdo(number, 2) for number in range(1, 5)] == [0x202, 0x302, 0x402, 0x502]
    assert canopen.sync() == CanFrame(0x080, b"")
    assert canopen.heartbeat(127) == CanFrame(0x77F, b"\x05")


def test_bit_7_of_a_heartbeat_is_no_part_of_the_state() -> None:
    assert canopen.decode_heartbeat(b"\x05") == canopen.decode_heartbeat(b"\x85") == NmtState.OPERATIONAL
    assert canopen.state_name(0x7F) == "pre-operational"
    assert canopen.state_name(0x42) == "state 0x42"


def test_the_position_s_mapping_entry_is_that_of_the_standard() -> None:
    assert canopen.mapping(0x6064, 0, 32) == 0x60640020


@mark.parametrize(("length", "command"), [(1, 0x2F), (2, 0x2B), (3, 0x27), (4, 0x23)])
def test_a_write_tells_its_length(length: int, command: int) -> None:
    frame = canopen.write_request(5, 0x1017, 0, bytes(range(1, length + 1)))
    assert frame.identifier == 0x605
    assert frame.data == bytes((command, 0x17, 0x10, 0, *range(1, length + 1))).ljust(8, b"\0")


@mark.parametrize(("command", "length"), [(0x43, 4), (0x47, 3), (0x4B, 2), (0x4F, 1), (0x42, 4)])
def test_a_reply_tells_how_many_bytes_count(command: int, length: int) -> None:
    reply = canopen.decode_sdo(bytes((command, 0x41, 0x60, 2, 1, 2, 3, 4)))
    assert reply == SdoReply(Kind.READ, 0x6041, 2, bytes((1, 2, 3, 4))[:length])


def test_a_write_is_confirmed_or_aborted_with_a_reason() -> None:
    assert canopen.decode_sdo(bytes.fromhex("6017100000000000")) == SdoReply(Kind.WRITTEN, 0x1017, 0)
    aborted = canopen.decode_sdo(bytes.fromhex("8017100000000206"))
    assert aborted == SdoReply(Kind.ABORTED, 0x1017, 0, abort=0x06020000)
    assert canopen.abort_name(0x06020000) == "no such object (0x06020000)"
    assert canopen.abort_name(0x12345678) == "abort (0x12345678)"


@given(st.binary(min_size=8, max_size=8))
def test_any_eight_bytes_are_a_reply_or_none(data: bytes) -> None:
    reply = canopen.decode_sdo(data)
    assert reply is None or reply.index == data[1] | data[2] << 8
    assert 0 <= canopen.decode_emergency(data).code <= 0xFFFF


@given(nodes, indices, subs, st.binary(min_size=1, max_size=4))
def test_what_is_written_stands_in_the_frame(node: int, index: int, sub: int, value: bytes) -> None:
    frame = canopen.write_request(node, index, sub, value)
    assert frame.data[1:4] == index.to_bytes(2, "little") + bytes((sub,))
    assert frame.data[4:] == value.ljust(4, b"\0")


def test_a_pdo_is_off_while_it_is_changed() -> None:
    writes = transmit(2, Pdo(1, (0x60640020, 0x606C0020), inhibit_ms=10, event_ms=20))
    assert [(write.index, write.sub, int.from_bytes(write.value, "little")) for write in writes] == [
        (0x1800, 1, 0x80000182),
        (0x1800, 2, 255),
        (0x1800, 3, 100),
        (0x1800, 5, 20),
        (0x1A00, 0, 0),
        (0x1A00, 1, 0x60640020),
        (0x1A00, 2, 0x606C0020),
        (0x1A00, 0, 2),
        (0x1800, 1, 0x182),
    ]


def test_a_pdo_that_follows_sync_needs_no_times() -> None:
    writes = transmit(2, Pdo(3, (0x60640020,), EACH_SYNC, 10, 10))
    assert [(write.index, write.sub) for write in writes][:3] == [(0x1802, 1), (0x1802, 2), (0x1A02, 0)]


def test_what_a_node_receives_has_objects_of_its_own() -> None:
    writes = receive(2, Pdo(4, (0x60400010, 0x60FF0020)))
    assert writes[0].value == (0x80000502).to_bytes(4, "little")
    assert {write.index for write in writes} == {0x1403, 0x1603}


@mark.parametrize(
    ("code", "name"),
    [
        (0x7310, "EMCY 0x7310 (speed)"),
        (0x8130, "EMCY 0x8130 (heartbeat of its master lost)"),
        (0x3211, "EMCY 0x3211 (over-voltage of the DC link)"),
        (0x3299, "EMCY 0x3299 (voltage inside the device)"),
        (0x3999, "EMCY 0x3999 (voltage)"),
        (0xFF05, "EMCY 0xff05 (its maker's own)"),
        (0xA000, "EMCY 0xa000"),
    ],
)
def test_an_error_code_has_the_nearest_name(code: int, name: str) -> None:
    assert emergency_name(code) == name


def test_sensor_errors_bus_errors_and_none_are_told_apart() -> None:
    assert [is_reset(code) for code in (0x0000, 0x00FF, 0x1000)] == [True, True, False]
    assert [blinds(code) for code in (0x7300, 0x7305, 0x7310, 0x7320)] == [True, True, False, False]
    assert [is_communication(code) for code in (0x8110, 0x8130, 0x8210)] == [True, True, False]
