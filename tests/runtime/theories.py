"""Theories that are not, for what judges theories: one knows the truth, one counts, one knows nothing."""

from typing import Self

import numpy as np

from echogrid.emulation.worlds import WORLDS
from echogrid.mapping.grid import GridGeometry, Patch
from echogrid.mapping.sounding import Sounding
from echogrid.runtime.map_suite import judged_cells

EVERYWHERE: Patch = (slice(None), slice(None))


class Told:
    """Says of all cells what it was told, from the first ping on."""

    def __init__(self, geometry: GridGeometry, image: np.ndarray) -> None:
        self.geometry, self.image, self.pings = geometry, image, 0

    def update(self, sounding: Sounding) -> Patch | None:
        self.pings += 1
        return EVERYWHERE

    def occupancy(self) -> np.ndarray:
        return self.image.astype(np.float32)

    def unknown(self) -> np.ndarray:
        return np.full(self.geometry.shape, self.pings == 0)

    def copy(self) -> Self:
        return type(self)(self.geometry, self.image)


class Counting(Told):
    """So many pings, so sure is it of every cell."""

    def occupancy(self) -> np.ndarray:
        return np.full(self.geometry.shape, self.pings / (self.pings + 1.0), np.float32)


def truth_of(world: str, geometry: GridGeometry) -> Told:
    """Cheats."""
    walls, _ = judged_cells(WORLDS[world](), geometry)
    return Told(geometry, walls)


def ignorant(world: str, geometry: GridGeometry) -> Told:
    """One half for everything."""
    return Told(geometry, np.full(geometry.shape, 0.5))


def counting(world: str, geometry: GridGeometry) -> Counting:
    """A new one."""
    return Counting(geometry, np.zeros(geometry.shape))
