"""Quantities as whole numbers of 16 bits, and the codes of reasons: the same in every binary output."""

from math import ceil, floor, inf

from echogrid.mapping.virtual_sensor import StopReason

NONE_U16 = 0xFFFF
BEARING_PER_RAD = 1e4
REASONS: dict[StopReason | None, int] = {None: 0} | {
    reason: code for code, reason in enumerate(StopReason, 1)
}


def millimetres(distance: float) -> int:
    """Rounded down, 65534 at most; 65535 if there is none."""
    return NONE_U16 if distance == inf else min(floor(distance * 1e3), NONE_U16 - 1)


def milliseconds(age_ns: int | None) -> int:
    """Rounded up, 65534 at most; 65535 if never."""
    return NONE_U16 if age_ns is None else min(ceil(age_ns / 1_000_000), NONE_U16 - 1)


def bearing(angle: float) -> int:
    """Tenths of a milliradian, -31416...31416."""
    return round(angle * BEARING_PER_RAD)
