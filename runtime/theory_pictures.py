"""What the book's three theories leave behind of the same few pings, as one picture for the docs."""

import sys
from collections.abc import Iterator, Sequence
from math import pi, radians
from pathlib import Path

import numpy as np

from echogrid.mapping.bayes import BayesGrid
from echogrid.mapping.dempster_shafer import DempsterShaferGrid
from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.himm import HimmGrid
from echogrid.mapping.long_term_map import MapImage
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.sonar_model import Form, NoEcho
from echogrid.mapping.sounding import Sounding
from echogrid.mapping.theories import MAP_LIMIT
from echogrid.mapping.theory import Theory
from echogrid.runtime import png
from echogrid.runtime.comparison_pictures import heat
from echogrid.runtime.map_picture import UNKNOWN, shades
from echogrid.runtime.picture_sheet import Picture, Pixels, sheet

GRID = GridGeometry.covering(-1.75, 0.0, 1.75, 3.0, 0.05)
SONAR = Ranger("sonar", Pose(), radians(15.0), 0.1, 4.0)
MOST_CONFLICT = 2.0
"""nats: as dark as can be."""

_TOLERANCE = 0.1
_NORTH, _EAST = pi / 2.0, 0.0


def scenes() -> tuple[tuple[Sounding, ...], ...]:
    """One echo; the same and one from the side that passes through; a wall, driven along three times."""
    echo = _ping(0.025, 0.125, _NORTH, 2.22)
    across = _ping(-1.675, 2.325, _EAST, 3.2)
    along = tuple(_ping(0.025 + 0.1 * step, 0.125, _NORTH, 2.22) for step in range(-12, 13))
    return (echo,), (echo, across), along * 3


def pictures() -> Iterator[Picture]:
    """For each scene Bayes' map, Dempster-Shafer's masses and their conflict, and HIMM's counts."""
    for pings in scenes():
        bayes = _heard(BayesGrid(GRID, MAP_LIMIT, Form.CONSISTENT, NoEcho.WEAK), pings)
        masses = DempsterShaferGrid(GRID, Form.CONSISTENT, NoEcho.WEAK)
        _heard(masses, pings)
        yield _picture("Bayes", _shaded(bayes))
        yield _picture("masses", _mixed(masses))
        yield _picture("conflict", heat(masses.conflict.astype(np.float64), MOST_CONFLICT, masses.unknown()))
        yield _picture("HIMM", _shaded(_heard(HimmGrid(GRID), pings)))


def _ping(x: float, y: float, yaw: float, echo: float) -> Sounding:
    return Sounding(Pose(x, y, yaw), SONAR, echo, _TOLERANCE)


def _heard(theory: Theory, pings: Sequence[Sounding]) -> Theory:
    for ping in pings:
        theory.update(ping)
    return theory


def _shaded(theory: Theory) -> Pixels:
    return shades(MapImage(GRID, theory.occupancy(), theory.unknown()))


def _mixed(masses: DempsterShaferGrid) -> Pixels:
    """m(Occ) of black, m(Emp) of white, and m(dk) of what is unknown."""
    unsure = 1.0 - masses.occupied - masses.empty
    mixed = masses.empty[..., np.newaxis] * 255.0 + unsure[..., np.newaxis] * np.array(UNKNOWN)
    result: Pixels = np.rint(mixed).astype(np.uint8)
    return result


def _picture(name: str, cells: Pixels) -> Picture:
    return Picture(name, "", cells[::-1])


if __name__ == "__main__":
    Path(sys.argv[1]).write_bytes(png.encode(sheet(list(pictures()))))
