"""The kernel's error frames: what happened on a CAN bus. Source: linux/can/error.h."""

from echogrid.drivers.transports.can_link import BusState

CLASSES = {
    0x001: "send time-outs",
    0x002: "arbitrations lost",
    0x004: "controller problems",
    0x008: "protocol violations",
    0x010: "transceiver problems",
    0x020: "missing acknowledges",
    0x040: "bus-offs",
    0x080: "bus errors",
    0x100: "restarts",
}
CONTROLLER, BUS_OFF, RESTARTED = 0x004, 0x040, 0x100
WARNING, PASSIVE, ACTIVE = 0x0C, 0x30, 0x40
"""Bits of the second byte of a controller problem: for either direction, where there are two."""


def error_classes(identifier: int) -> list[str]:
    """The names of what happened; several may have, and none that is known."""
    return [name for bit, name in CLASSES.items() if identifier & bit]


def told_state(identifier: int, data: bytes) -> BusState | None:
    """How the controller is from now on; None if the frame does not say that."""
    if identifier & BUS_OFF:
        return BusState.BUS_OFF
    if identifier & RESTARTED:
        return BusState.ERROR_ACTIVE
    problem = data[1] if identifier & CONTROLLER and len(data) > 1 else 0
    if problem & PASSIVE:
        return BusState.ERROR_PASSIVE
    if problem & WARNING:
        return BusState.ERROR_WARNING
    return BusState.ERROR_ACTIVE if problem & ACTIVE else None
