"""The states of an emulated drive after CiA 402, each by its bits in the status word."""

SWITCH_ON_DISABLED, READY_TO_SWITCH_ON, SWITCHED_ON = 0x40, 0x21, 0x23
OPERATION_ENABLED, QUICK_STOP_ACTIVE, FAULT = 0x27, 0x07, 0x08
_VOLTAGE, _REMOTE = 1 << 4, 1 << 9
_SWITCH_ON, _ENABLE_VOLTAGE, _NO_QUICK_STOP = 1, 2, 4
_FAULT_RESET = 1 << 7

_TRANSITIONS = {
    SWITCH_ON_DISABLED: {6: READY_TO_SWITCH_ON},
    READY_TO_SWITCH_ON: {7: SWITCHED_ON, 15: OPERATION_ENABLED},
    SWITCHED_ON: {6: READY_TO_SWITCH_ON, 15: OPERATION_ENABLED},
    OPERATION_ENABLED: {6: READY_TO_SWITCH_ON, 7: SWITCHED_ON},
}
"""State, bits 0 to 3 of the control word (of 6, shutdown, only the lower three count): next state."""


class StateMachine:
    """Where the drive is, and where a control word takes it."""

    def __init__(self) -> None:
        self.state = SWITCH_ON_DISABLED
        self._reset_before = False

    @property
    def word(self) -> int:
        """The status word."""
        return self.state | _VOLTAGE | _REMOTE

    def fail(self) -> None:
        """A fault has come; its reaction takes no time."""
        self.state = FAULT

    def commanded(self, word: int, faulty: bool) -> int:
        """The next state; a fault which lasts can't be reset."""
        rising = bool(word & _FAULT_RESET) and not self._reset_before
        self._reset_before = bool(word & _FAULT_RESET)
        if self.state == FAULT:
            return SWITCH_ON_DISABLED if rising and not faulty else FAULT
        if not word & _ENABLE_VOLTAGE:
            return SWITCH_ON_DISABLED
        if not word & _NO_QUICK_STOP:
            stops = self.state in (OPERATION_ENABLED, QUICK_STOP_ACTIVE)
            return QUICK_STOP_ACTIVE if stops else SWITCH_ON_DISABLED
        low = word & 0x0F
        return _TRANSITIONS.get(self.state, {}).get(low if low & _SWITCH_ON else 6, self.state)
