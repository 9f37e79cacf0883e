"""How a node's PDOs are set up: the writes to its objects, in the order which the standard demands."""

from collections.abc import Sequence
from dataclasses import dataclass

from echogrid.drivers import canopen
from echogrid.drivers.sdo import SdoWrite

RPDO_SETTINGS, RPDO_MAPPING = 0x1400, 0x1600
TPDO_SETTINGS, TPDO_MAPPING = 0x1800, 0x1A00
IDENTIFIER, TYPE, INHIBIT, EVENT_TIMER = 1, 2, 3, 5
"""Sub-indices of the settings."""
EACH_SYNC, BY_EVENT = 1, 255
"""Transmission types."""
INVALID = 0x8000_0000
"""In the identifier: the PDO is off."""
INHIBIT_UNITS_PER_MS = 10


@dataclass(frozen=True, slots=True)
class Pdo:
    """One PDO of a node."""

    number: int
    """1 to 4."""
    entries: tuple[int, ...]
    """What is in it; see canopen.mapping."""
    type: int = BY_EVENT
    inhibit_ms: int = 0
    """By event it is sent again so much later at the earliest."""
    event_ms: int = 0
    """By event it is sent after so long at the latest."""


def transmit(node: int, pdo: Pdo) -> tuple[SdoWrite, ...]:
    """What makes a node send it."""
    settings, offset = TPDO_SETTINGS + pdo.number - 1, TPDO_MAPPING - TPDO_SETTINGS
    times: tuple[SdoWrite, ...] = ()
    if pdo.type == BY_EVENT:
        times = (
            SdoWrite(settings, INHIBIT, _bytes(pdo.inhibit_ms * INHIBIT_UNITS_PER_MS, 2)),
            SdoWrite(settings, EVENT_TIMER, _bytes(pdo.event_ms, 2)),
        )
    return _set_up(settings, offset, canopen.tpdo(pdo.number, node), pdo, times)


def receive(node: int, pdo: Pdo) -> tuple[SdoWrite, ...]:
    """What makes a node take it."""
    settings, offset = RPDO_SETTINGS + pdo.number - 1, RPDO_MAPPING - RPDO_SETTINGS
    return _set_up(settings, offset, canopen.rpdo(pdo.number, node), pdo, ())


def _set_up(
    settings: int, offset: int, identifier: int, pdo: Pdo, times: Sequence[SdoWrite]
) -> tuple[SdoWrite, ...]:
    """Off, changed, and on again: a PDO that is on must not be changed."""
    mapping = settings + offset
    entries = (SdoWrite(mapping, sub, _bytes(entry, 4)) for sub, entry in enumerate(pdo.entries, 1))
    return (
        SdoWrite(settings, IDENTIFIER, _bytes(identifier | INVALID, 4)),
        SdoWrite(settings, TYPE, _bytes(pdo.type, 1)),
        *times,
        SdoWrite(mapping, 0, _bytes(0, 1)),
        *entries,
        SdoWrite(mapping, 0, _bytes(len(pdo.entries), 1)),
        SdoWrite(settings, IDENTIFIER, _bytes(identifier, 4)),
    )


def _bytes(value: int, length: int) -> bytes:
    return value.to_bytes(length, "little")
