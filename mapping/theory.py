"""What every way of fusing pings into a grid has in common."""

from collections.abc import Mapping
from typing import Protocol, Self, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.grid import GridGeometry, Patch
from echogrid.mapping.sounding import Sounding


class Theory(Protocol):
    """A way of fusing pings into a grid."""

    geometry: GridGeometry

    def update(self, sounding: Sounding) -> Patch | None:
        """Fuse one ping; the patch that it touched, None if it said nothing."""
        ...

    def occupancy(self) -> NDArray[np.float32]:
        """(rows, cols) P(Occupied), row 0 = south; 0.5 where unknown."""
        ...

    def unknown(self) -> NDArray[np.bool_]:
        """(rows, cols) True where no ping has spoken."""
        ...

    def copy(self) -> Self:
        """An independent twin."""
        ...


@runtime_checkable
class Layered(Protocol):
    """A theory which has more maps to tell than what is occupied."""

    def layers(self) -> Mapping[str, NDArray[np.float32]]:
        """(rows, cols) each, row 0 = south, by name."""
        ...


def layers(theory: Theory) -> Mapping[str, NDArray[np.float32]]:
    """What else a theory has to tell: (rows, cols) each, row 0 = south, by name; empty if it has no more."""
    return theory.layers() if isinstance(theory, Layered) else {}
