"""The flags of a Roboteq controller: what is wrong (FF, 2112h), and how it is (FS, 2111h).

Controllers User Manual V2.0 (2019), read status flags and read fault flags; STO from the maker's help pages.
"""

from collections.abc import Mapping, Sequence

from echogrid.drivers.sdo import SdoAnswer, SdoRead

STATUS_FLAGS, FAULT_FLAGS = SdoRead(0x2111), SdoRead(0x2112)
LAST_NS = 3_000_000_000
"""So long they are remembered; they are asked for each second."""

OVERHEAT = 0x01
EMERGENCY_STOP = 0x10
DEFAULTS_LOADED = 0x80

FAULTS = {
    OVERHEAT: "overheat",
    0x02: "overvoltage",
    0x04: "undervoltage",
    0x08: "short circuit",
    EMERGENCY_STOP: "emergency stop",
    0x20: "motor or sensor set-up fault",
    0x40: "MOSFET failure",
    DEFAULTS_LOADED: "default configuration loaded at start",
    0x100: "safe torque off fault",
}
STATUS = {
    0x01: "serial mode",
    0x02: "pulse mode",
    0x04: "analog mode",
    0x08: "power stage off",
    0x10: "stall",
    0x20: "at limit",
    0x80: "script running",
    0x100: "being set up",
}
MENDS = {
    OVERHEAT: "let it cool, load it less",
    EMERGENCY_STOP: "release it",
    DEFAULTS_LOADED: "load its configuration again",
}


def flag_names(flags: int, known: Mapping[int, str]) -> str:
    """Those that are set, by name or else by number; empty if none is."""
    bits = (1 << bit for bit in range(flags.bit_length()) if flags >> bit & 1)
    return ", ".join(known.get(bit, f"flag {bit:#x}") for bit in bits)


class Flags:
    """What was last told of both words."""

    def __init__(self) -> None:
        self._told: dict[SdoRead, tuple[int, int]] = {}
        self._refused: dict[SdoRead, str] = {}

    def forget(self) -> None:
        """Nothing is known any more."""
        self._told, self._refused = {}, {}

    def take(self, stamp_ns: int, read: SdoRead, answer: SdoAnswer) -> None:
        """The answer to the request for one of them, 1 to 4 bytes or a refusal."""
        if answer.trouble:
            self._refused[read] = answer.trouble
            return
        self._refused.pop(read, None)
        self._told[read] = stamp_ns, int.from_bytes(answer.data, "little")

    def faults(self, now_ns: int) -> int:
        """Those that there are, as far as is known."""
        return self._fresh(FAULT_FLAGS, now_ns)

    def remarks(self, now_ns: int) -> Sequence[str]:
        """How it is, and what of that it does not tell."""
        status = flag_names(self._fresh(STATUS_FLAGS, now_ns), STATUS)
        told = [f"status: {status}"] if status else []
        return [*told, *(f"flags not known: {refusal}" for refusal in tuple(self._refused.values()))]

    def _fresh(self, read: SdoRead, now_ns: int) -> int:
        stamp_ns, flags = self._told.get(read, (-LAST_NS, 0))
        return flags if now_ns - stamp_ns <= LAST_NS else 0


def fault_report(faults: int) -> str:
    """Their names, and what to do."""
    mends = [mend for bit, mend in MENDS.items() if faults & bit]
    return f"{flag_names(faults, FAULTS)}: {', '.join(mends) or 'see to it at the controller'}"
