"""The rangers with FF H L SUM frames: what is known of each part, and what a user says otherwise."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal

from echogrid.drivers.limits import require_between
from echogrid.drivers.readings import Outcome

PartName = Literal["a02yyuw", "a01nyub", "me007ys", "jsn-sr04t", "aj-sr04m", "dyp-a02"]


@dataclass(frozen=True, slots=True)
class Part:
    """What differs between the parts."""

    reach_m: float
    """As far as it ranges by its data sheet."""
    lag_ms: float = 200.0
    """Sending unasked: from the sound meeting the obstacle to the first byte. The data sheets say 100 to
    300 ms for the filtered value (RX open), 100 ms for the real-time one (RX low)."""
    lag_error_ms: float = 100.0
    no_echo_mm: tuple[int, ...] = (0, 0xFFFD)
    """What is sent when nothing is heard. No data sheet says: 0 was seen, newer parts send 0xFFFD, some
    their longest distance."""
    invalid_mm: tuple[int, ...] = (0xFFFE,)
    """What is sent when the measurement failed: newer parts send 0xFFFE, interference."""
    header_summed: bool = True
    """Whether the header counts in SUM; some boards add up H and L only."""
    trigger: int = 0x55
    """The byte at which it pings, set up to send on demand only."""

    @property
    def codes(self) -> Mapping[int, tuple[Outcome, str]]:
        """The values that are no distances: what each means, and why if it is INVALID."""
        invalid = {code: (Outcome.INVALID, f"code {code:#06x}") for code in self.invalid_mm}
        return invalid | dict.fromkeys(self.no_echo_mm, (Outcome.NO_ECHO, ""))


PARTS: Mapping[PartName, Part] = {
    "a02yyuw": Part(reach_m=4.5),
    "a01nyub": Part(reach_m=7.5, lag_ms=225.0, lag_error_ms=75.0),
    "me007ys": Part(reach_m=4.5),
    "jsn-sr04t": Part(reach_m=6.0, lag_ms=50.0, lag_error_ms=50.0),
    "aj-sr04m": Part(reach_m=4.5, lag_ms=50.0, lag_error_ms=50.0, trigger=0x01),
    "dyp-a02": Part(reach_m=4.5),
}


@dataclass(frozen=True, slots=True)
class PartSettings:
    """The keys which all drivers of these parts have in a config file. None: as the part has it."""

    part: PartName = "a02yyuw"
    baud: int = 9600
    reach_m: float | None = None
    no_echo_mm: tuple[int, ...] | None = None
    invalid_mm: tuple[int, ...] | None = None
    header_summed: bool | None = None

    def __post_init__(self) -> None:
        if self.part not in PARTS:
            raise ValueError(f"part is {self.part!r}: expected one of {', '.join(PARTS)}")
        require_between("baud", self.baud, 1200, 921_600)
        require_between("reach_m", self.chosen.reach_m, 0.1, 10.0)
        for key, codes in (("no_echo_mm", self.no_echo_mm), ("invalid_mm", self.invalid_mm)):
            for code in codes or ():
                require_between(key, code, 0, 0xFFFF)

    @property
    def chosen(self) -> Part:
        """The part as its user has it."""
        keys = ("reach_m", "no_echo_mm", "invalid_mm", "header_summed")
        own = {key: getattr(self, key) for key in keys if getattr(self, key) is not None}
        return replace(PARTS[self.part], **own)

    def garbled(self) -> str:
        """What to look for when bytes come but no frames."""
        header = "with" if self.chosen.header_summed else "without"
        return f"does it send at {self.baud} baud, not inverted, {header} the header in its sum?"
