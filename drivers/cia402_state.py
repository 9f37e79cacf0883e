"""The state of a drive (CiA 402) in its status word 6041h."""

from enum import Enum


class DriveState(Enum):
    """Mask and value of the status word."""

    NOT_READY = 0x4F, 0x00
    SWITCH_ON_DISABLED = 0x4F, 0x40
    READY = 0x6F, 0x21
    SWITCHED_ON = 0x6F, 0x23
    ENABLED = 0x6F, 0x27
    QUICK_STOP = 0x6F, 0x07
    FAULT_REACTION = 0x4F, 0x0F
    FAULT = 0x4F, 0x08

    @property
    def title(self) -> str:
        """As the standard calls it."""
        return _TITLES[self]


_TITLES = {
    DriveState.NOT_READY: "not ready to switch on",
    DriveState.SWITCH_ON_DISABLED: "switch on disabled",
    DriveState.READY: "ready to switch on",
    DriveState.SWITCHED_ON: "switched on",
    DriveState.ENABLED: "operation enabled",
    DriveState.QUICK_STOP: "quick stop active",
    DriveState.FAULT_REACTION: "fault reaction active",
    DriveState.FAULT: "fault",
}
FAULTS = frozenset({DriveState.FAULT_REACTION, DriveState.FAULT})


def drive_state(status: int) -> DriveState | None:
    """The state that a status word says; None: it is none of the standard's."""
    for state in DriveState:
        mask, value = state.value
        if status & mask == value:
            return state
    return None
