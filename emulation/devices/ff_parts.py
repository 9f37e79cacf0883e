"""What the emulated rangers with FF H L SUM frames have in common: the frame, and how the parts differ."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

SILENT = -1
"""Instead of a value: no frame."""
_HEADER = 0xFF


@dataclass(frozen=True, slots=True)
class FfPart:
    """One part."""

    nearest: float
    """m: what is nearer reads as something below."""
    reach: float
    """m."""
    lag_ns: int
    """Sending unasked: from the echo's arrival (or the end of listening) to the first bit."""
    no_echo: int
    """The value (mm) sent when nothing is heard: no sheet says. SILENT sends nothing."""
    trigger: int = 0x55
    """The byte at which it pings, if it is set up to send on demand."""


FF_PARTS: Mapping[str, FfPart] = {
    "a02yyuw": FfPart(nearest=0.03, reach=4.5, lag_ns=100_000_000, no_echo=0),
    "a01nyub": FfPart(nearest=0.28, reach=7.5, lag_ns=150_000_000, no_echo=0),
    "me007ys": FfPart(nearest=0.28, reach=4.5, lag_ns=100_000_000, no_echo=0),
    "jsn-sr04t": FfPart(nearest=0.2, reach=6.0, lag_ns=50_000_000, no_echo=0),
    "aj-sr04m": FfPart(nearest=0.2, reach=4.5, lag_ns=50_000_000, no_echo=0, trigger=0x01),
    "dyp-a02": FfPart(nearest=0.03, reach=4.5, lag_ns=100_000_000, no_echo=0xFFFD),
}


@dataclass(frozen=True, slots=True)
class FfOptions:
    """What all models of these parts let choose. None: as the part has it."""

    part: str = "a02yyuw"
    reach: float | None = None
    """m."""
    no_echo: int | None = None
    """The value (mm) sent when nothing is heard; -1 sends nothing."""
    header_summed: bool = True
    """Some boards sum up H and L only."""

    def __post_init__(self) -> None:
        if self.part not in FF_PARTS:
            raise ValueError(f"no part {self.part!r} (there are: {', '.join(FF_PARTS)})")

    @property
    def chosen(self) -> FfPart:
        """The part as it is."""
        part = FF_PARTS[self.part]
        reach = part.reach if self.reach is None else self.reach
        return replace(part, reach=reach, no_echo=part.no_echo if self.no_echo is None else self.no_echo)

    def message(self, distance: float | None) -> bytes:
        """The frame for the first echo (m); an object in the blind zone reads as a value below the minimum,
        but never as the no-echo 0."""
        if distance is None:
            return b"" if self.chosen.no_echo == SILENT else frame(self.chosen.no_echo, self.header_summed)
        if distance < self.chosen.nearest:
            return frame(max(1, int(distance * 1000)), self.header_summed)
        return frame(round(distance * 1000), self.header_summed)


def frame(millimetres: int, header_summed: bool = True) -> bytes:
    """FF H L SUM."""
    high, low = divmod(millimetres, 256)
    return bytes((_HEADER, high, low, (high + low + (_HEADER if header_summed else 0)) & 0xFF))
