"""CANopen's messages (CiA 301), as far as a driver needs them: pure, all little-endian."""

from dataclasses import dataclass
from enum import Enum, IntEnum
from struct import Struct

from echogrid.drivers.bus import CanFrame

NMT, SYNC, EMERGENCY, HEARTBEAT = 0x000, 0x080, 0x080, 0x700
"""Identifiers; to the latter two the node is added."""
SDO_REPLY, SDO_REQUEST = 0x580, 0x600
TPDO, RPDO = 0x180, 0x200
PDOS = 4
"""So many of each kind have an identifier from the standard."""
LENGTH = 8
"""Of SDO and EMCY frames."""

_OBJECT = Struct("<BHB4s")
_EMERGENCY = Struct("<HB5s")


class Command(IntEnum):
    """What the network's master tells a node."""

    START = 0x01
    STOP = 0x02
    PRE_OPERATIONAL = 0x80
    RESET_NODE = 0x81
    RESET_COMMUNICATION = 0x82


class NmtState(IntEnum):
    """What a node says in its heartbeat."""

    BOOT = 0x00
    STOPPED = 0x04
    OPERATIONAL = 0x05
    """The only one in which PDOs count."""
    PRE_OPERATIONAL = 0x7F


def tpdo(number: int, node: int) -> int:
    """The identifier of what a node sends as its TPDO of that number, 1 to 4."""
    return TPDO + 0x100 * (number - 1) + node


def rpdo(number: int, node: int) -> int:
    """The identifier of what a node receives as its RPDO of that number, 1 to 4."""
    return RPDO + 0x100 * (number - 1) + node


def nmt(command: Command, node: int) -> CanFrame:
    """A command to a node; 0 is all of them."""
    return CanFrame(NMT, bytes((command, node)))


def sync() -> CanFrame:
    """The signal at which synchronous PDOs are sent."""
    return CanFrame(SYNC, b"")


def heartbeat(node: int) -> CanFrame:
    """A heartbeat of our own: we are always operational."""
    return CanFrame(HEARTBEAT + node, bytes((NmtState.OPERATIONAL,)))


def decode_heartbeat(data: bytes) -> int:
    """The state in a heartbeat, mostly an NmtState; without bit 7, which node guarding toggles."""
    return data[0] & 0x7F


def state_name(state: int) -> str:
    """The name of a state in a heartbeat."""
    known = state in NmtState.__members__.values()
    return NmtState(state).name.lower().replace("_", "-") if known else f"state {state:#04x}"


@dataclass(frozen=True, slots=True)
class Emergency:
    """EMCY: a node's error has come or gone."""

    code: int
    """0x00xx: no error any more."""
    register: int
    vendor: bytes


def decode_emergency(data: bytes) -> Emergency:
    """What the 8 bytes of an EMCY say."""
    code, register, vendor = _EMERGENCY.unpack(data)
    return Emergency(code, register, vendor)


def mapping(index: int, sub: int, bits: int) -> int:
    """The entry of an object in the mapping of a PDO."""
    return index << 16 | sub << 8 | bits


class Kind(Enum):
    """What a reply is."""

    READ = "read"
    WRITTEN = "written"
    ABORTED = "aborted"


@dataclass(frozen=True, slots=True)
class SdoReply:
    """What a node says to a request for an object."""

    kind: Kind
    index: int
    sub: int
    data: bytes = b""
    """What was read: 1 to 4 bytes; 4 if the node does not tell how many count."""
    abort: int = 0
    """Why it was not done; see `abort_name`."""


_READ = 0x40
_READ_LENGTHS = {0x43: 4, 0x47: 3, 0x4B: 2, 0x4F: 1, 0x42: 4}
_WRITE = {4: 0x23, 3: 0x27, 2: 0x2B, 1: 0x2F}
"""By the length of the value."""
_WRITTEN = 0x60
_ABORT = 0x80


def read_request(node: int, index: int, sub: int) -> CanFrame:
    """Asks a node for an object of up to 4 bytes."""
    return CanFrame(SDO_REQUEST + node, _OBJECT.pack(_READ, index, sub, b""))


def write_request(node: int, index: int, sub: int, value: bytes) -> CanFrame:
    """Sets an object of a node to 1 to 4 bytes."""
    return CanFrame(SDO_REQUEST + node, _OBJECT.pack(_WRITE[len(value)], index, sub, value))


def decode_sdo(data: bytes) -> SdoReply | None:
    """What the 8 bytes of a reply say; None: it is none to the requests here (segments, blocks)."""
    command, index, sub, value = _OBJECT.unpack(data)
    if command in _READ_LENGTHS:
        return SdoReply(Kind.READ, index, sub, value[: _READ_LENGTHS[command]])
    if command == _WRITTEN:
        return SdoReply(Kind.WRITTEN, index, sub)
    if command == _ABORT:
        return SdoReply(Kind.ABORTED, index, sub, abort=int.from_bytes(value, "little"))
    return None


ABORTS = {
    0x0503_0000: "toggle bit not alternated",
    0x0504_0000: "its SDO timed out",
    0x0504_0001: "unknown command",
    0x0504_0005: "out of memory",
    0x0601_0000: "unsupported access",
    0x0601_0001: "can only be written",
    0x0601_0002: "can only be read",
    0x0602_0000: "no such object",
    0x0604_0041: "can't be mapped to a PDO",
    0x0604_0042: "PDO would be too long",
    0x0604_0043: "parameters don't fit together",
    0x0604_0047: "incompatible in the device",
    0x0606_0000: "hardware error",
    0x0607_0010: "wrong length",
    0x0607_0012: "too long",
    0x0607_0013: "too short",
    0x0609_0011: "no such sub-index",
    0x0609_0030: "invalid value",
    0x0609_0031: "value too high",
    0x0609_0032: "value too low",
    0x0609_0036: "maximum below minimum",
    0x060A_0023: "resource not available",
    0x0800_0000: "general error",
    0x0800_0020: "can't be transferred or stored",
    0x0800_0021: "not while it is controlled locally",
    0x0800_0022: "not in its present state",
    0x0800_0023: "no object dictionary",
    0x0800_0024: "no data",
}
"""Why a request was not done."""


def abort_name(code: int) -> str:
    """The meaning of an abort code, with its number."""
    return f"{ABORTS.get(code, 'abort')} ({code:#010x})"
