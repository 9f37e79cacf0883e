"""What a robot makes itself believe by standing still: two hundred pings alike, beside three that are not.

The book's robot (11.6) which repeats one wrong reading corrupts its map by every theory. Pings that are alike
share their error, so all of them together ought to say no more than a few from elsewhere.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import cos, pi, radians, sin

from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.sounding import Sounding
from echogrid.mapping.theory import Theory
from echogrid.runtime.acoustics_check import REACH_M
from echogrid.runtime.map_suite import RESOLUTION_M, Contender
from echogrid.runtime.ring_recording import HALF_ANGLE, NEAREST_M, TOLERANCE_M

ALIKE = 200
APART = radians(40.0)
"""Between the directions from which the cell is looked at."""
GRID = GridGeometry.covering(-5.0, -5.0, 5.0, 5.0, RESOLUTION_M)
LOOKED_AT = GRID.cell(0.05, 0.05)
_ROUNDING = 1e-6


@dataclass(frozen=True, slots=True)
class Cell:
    """How a cell lies in the cone of each ping."""

    distance: float
    """m."""
    bearing: float
    """rad off the axis."""
    behind: float
    """m: so much further than the cell is the echo."""


CELLS: Mapping[str, Cell] = {
    "echo: 2 m, on the axis": Cell(2.0, 0.0, 0.0),
    "3.5 m, 10 deg off": Cell(3.5, radians(10.0), 0.0),
    "free: 2 m, on the axis": Cell(2.0, 0.0, 1.0),
    "3.5 m, 10 deg off it": Cell(3.5, radians(10.0), 1.0),
}


@dataclass(frozen=True, slots=True)
class Moved:
    """P(Occupied) of a cell after so many pings."""

    once: float
    thrice: float
    """From three poses, well apart from each other."""
    alike: float
    """After all that are alike."""

    @property
    def as_once(self) -> bool:
        """Whether all that are alike say what the first of them did."""
        return abs(self.alike - self.once) <= _ROUNDING

    @property
    def within_three(self) -> bool:
        """Whether all that are alike move it no further than the three, to the side where those move it."""
        up = self.thrice - 0.5
        return (self.alike - 0.5) * up <= up * up + _ROUNDING


def moved(contender: Contender, world: str, cell: Cell) -> Moved:
    """What a theory, as it is made for that world, comes to believe."""
    pings = [sounding(index, cell) for index in range(3)]
    return Moved(
        *(_after(contender.make(world, GRID), each) for each in (pings[:1], pings, pings[:1] * ALIKE))
    )


def _after(theory: Theory, pings: Sequence[Sounding]) -> float:
    for ping in pings:
        theory.update(ping)
    return float(theory.occupancy()[LOOKED_AT])


def sounding(index: int, cell: Cell) -> Sounding:
    """A ping from one of several directions, with the cell where it should be in the cone."""
    x, y, direction = GRID.x_centres[LOOKED_AT[1]], GRID.y_centres[LOOKED_AT[0]], index * APART
    seat = Pose(
        x + cell.distance * cos(direction),
        y + cell.distance * sin(direction),
        direction + pi + cell.bearing,
    )
    ranger = Ranger(f"sonar_{index}", Pose(), HALF_ANGLE, NEAREST_M, REACH_M)
    return Sounding(seat, ranger, cell.distance + cell.behind, TOLERANCE_M)
