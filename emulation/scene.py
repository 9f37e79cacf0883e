"""What an emulated ranger hears: the seam between acoustics and devices."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum


class Kind(IntEnum):
    """What returned the sound."""

    WALL = 0
    CORNER = 1
    EDGE = 2
    CYLINDER = 3
    ROUGH = 4
    BOUNCE = 5
    CROSSTALK = 6
    """Not an echo at all: the sound of another ping."""


@dataclass(frozen=True, slots=True)
class Echo:
    """One sound that comes back to the transducer."""

    distance: float
    """m, half of the way that the sound went since the ranger fired; crosstalk started earlier or later."""
    margin: float
    """dB above the detection threshold at full gain; negative ones are not heard."""
    kind: str
    """The name of its Kind in small letters: "wall", "corner", "edge" and so on."""


Scene = Callable[[int], tuple[Echo, ...]]
"""Fire time (ns, CLOCK_MONOTONIC) -> the echoes heard, nearest first; () when none. Dropouts and range
noise are already in it."""
