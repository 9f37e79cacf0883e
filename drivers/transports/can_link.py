"""What the kernel knows of a CAN interface, read by netlink.

Sources: rtnetlink(7), linux/if_link.h, linux/can/netlink.h.
"""

import socket
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from enum import Enum
from struct import Struct, error

WITHIN_S = 0.1
MOST_BYTES = 1 << 15

GET_LINK, NEW_LINK, REQUEST = 18, 16, 1
IS_UP = 1
HEADER = Struct("=IHHII")
"""Length, type, flags, sequence number, port."""
LINK = Struct("=BxHiII")
"""Family, type, index, flags, change."""
ATTRIBUTE = Struct("=HH")
"""Length with this head, type."""
TYPE_BITS = 0x3FFF
NAME, MTU, LINK_INFO, STATISTICS = 3, 4, 18, 23
INFO_KIND, INFO_DATA, INFO_STATISTICS = 1, 2, 3
CAN_BIT_TIMING, CAN_STATE, CAN_RESTART_MS, CAN_ERROR_COUNTERS, CAN_DATA_BIT_TIMING = 1, 4, 6, 8, 9
FD_MTU = 72
"""CANFD_MTU: what an interface must take, to take the frames of CAN-FD."""
U32 = Struct("=I")
ERROR_COUNTERS = Struct("=HH")
CAN_COUNTS = (
    "bus errors",
    "error warnings",
    "error passives",
    "bus-offs",
    "arbitrations lost",
    "restarts",
)
"""struct can_device_stats."""
DROPPED, OVERRUN = 6 * 8, 11 * 8
"""Where struct rtnl_link_stats64 has rx_dropped and rx_over_errors."""
U64 = Struct("=Q")


class BusState(Enum):
    """How a CAN controller takes part in its bus, by its error counters."""

    ERROR_ACTIVE = 0
    ERROR_WARNING = 1
    ERROR_PASSIVE = 2
    BUS_OFF = 3
    STOPPED = 4
    SLEEPING = 5


@dataclass(frozen=True, slots=True)
class CanLink:
    """A CAN interface as it is set up, and how it fares. What its driver does not say is None."""

    index: int
    """Another, if it was unplugged and plugged in again."""
    up: bool
    kind: str = ""
    """"can", "vcan", ..."""
    bitrate: int | None = None
    restart_ms: int | None = None
    """After a bus-off the kernel starts it again so much later; 0: never."""
    state: BusState | None = None
    errors: tuple[int, int] | None = None
    """The error counters, of sending and of receiving."""
    counts: Mapping[str, int] = field(default_factory=dict)
    """What happened since the interface is there, by name."""
    mtu: int | None = None
    data_bitrate: int | None = None
    """With which it sends the data of CAN-FD frames."""


def read_link(name: str) -> CanLink | None:
    """The interface of that name; None if there is none. Raises OSError if the kernel can't be asked."""
    with socket.socket(socket.AF_NETLINK, socket.SOCK_RAW, socket.NETLINK_ROUTE) as kernel:
        kernel.settimeout(WITHIN_S)
        kernel.send(request(name))
        return parse(kernel.recv(MOST_BYTES))


def request(name: str) -> bytes:
    """The question for that interface."""
    text = name.encode() + b"\0"
    attribute = ATTRIBUTE.pack(ATTRIBUTE.size + len(text), NAME) + text
    body = LINK.pack(0, 0, 0, 0, 0) + attribute + bytes(-len(attribute) % 4)
    return HEADER.pack(HEADER.size + len(body), GET_LINK, REQUEST, 1, 0) + body


def parse(answer: bytes) -> CanLink | None:
    """What the kernel's answer says; None if it is an error, or cut short."""
    try:
        length, kind, *_ = HEADER.unpack_from(answer)
        if kind != NEW_LINK:
            return None
        _, _, index, flags, _ = LINK.unpack_from(answer, HEADER.size)
        found = attributes(answer[HEADER.size + LINK.size : length])
        return _link(index, bool(flags & IS_UP), found)
    except error:
        return None


def attributes(packed: bytes) -> dict[int, bytes]:
    """Contents by type."""
    return dict(_each(packed))


def _each(packed: bytes) -> Iterator[tuple[int, bytes]]:
    at = 0
    while at + ATTRIBUTE.size <= len(packed):
        length, kind = ATTRIBUTE.unpack_from(packed, at)
        if length < ATTRIBUTE.size:
            return
        yield kind & TYPE_BITS, packed[at + ATTRIBUTE.size : at + length]
        at += length + -length % 4


def _link(index: int, up: bool, found: Mapping[int, bytes]) -> CanLink:
    info = attributes(found.get(LINK_INFO, b""))
    can = attributes(info.get(INFO_DATA, b""))
    state = _number(can.get(CAN_STATE))
    counters = can.get(CAN_ERROR_COUNTERS)
    return CanLink(
        index,
        up,
        info.get(INFO_KIND, b"").rstrip(b"\0").decode("ascii", "replace"),
        _number(can.get(CAN_BIT_TIMING)),
        _number(can.get(CAN_RESTART_MS)),
        BusState(state) if state is not None and state <= BusState.SLEEPING.value else None,
        ERROR_COUNTERS.unpack_from(counters) if counters else None,
        {**_counts(info.get(INFO_STATISTICS, b"")), **_overruns(found.get(STATISTICS, b""))},
        _number(found.get(MTU)),
        _number(can.get(CAN_DATA_BIT_TIMING)),
    )


def _number(packed: bytes | None) -> int | None:
    """The first number in it."""
    return None if packed is None else int(U32.unpack_from(packed)[0])


def _counts(packed: bytes) -> dict[str, int]:
    numbers = (number for (number,) in U32.iter_unpack(packed[: len(packed) // 4 * 4]))
    return dict(zip(CAN_COUNTS, numbers, strict=False))


def _overruns(packed: bytes) -> dict[str, int]:
    """Frames that came faster than they were taken."""
    if len(packed) < OVERRUN + U64.size:
        return {}
    return {"overruns": sum(int(U64.unpack_from(packed, at)[0]) for at in (DROPPED, OVERRUN))}
