"""Dempster-Shafer's grid: what speaks for an obstacle, what for empty space, and what is not known.

Murphy, Introduction to AI Robotics, 11.4. Of each cell's unit mass a part m(Occ) is committed to occupied, a
part m(Emp) to empty, and the rest m(dk) to neither ("don't know"). A cell that is not known has m(dk) = 1;
one about which pings contradict each other has not, and its weight of conflict tells so.
"""

from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.cone import Cone, Floats, cast
from echogrid.mapping.grid import GridGeometry, Patch
from echogrid.mapping.sonar_model import NoEcho, SonarModel, evidence
from echogrid.mapping.sounding import Sounding

FLOOR = 0.02
"""m(dk) stays at least this: else twenty pings of .9 would leave 1e-20, and no ping could move the cell."""
TOTAL = 20.0
"""nats: a conflict of this weight is total, and no greater one is counted."""
WHISPER = 0.0005
"""nats: evidence below this is none, as for Bayes' grid."""

Layer = NDArray[np.float32]


class TotalConflict(Enum):
    """What becomes of a cell when Dempster's rule has no answer, as all that is left contradicts itself."""

    RESET = "reset"
    """Nothing is known of it any more."""
    YAGER = "yager"
    """All that is in conflict goes to "don't know" (Yager): what little is not remains."""
    KEEP = "keep"
    """The ping that contradicts is not believed."""


class Masses(NamedTuple):
    """m(Occ), m(Emp) and m(dk), arrays of one shape; their sum is 1."""

    occupied: Floats
    empty: Floats
    unsure: Floats


class Combination(NamedTuple):
    """What Dempster's rule makes of two bodies of evidence."""

    masses: Masses
    conflict: Floats
    """Con (11.10), nats, at most `TOTAL`."""
    total: NDArray[np.bool_]
    """Where the conflict is total, and a policy decided."""


def simple_support(log_ratio: Floats) -> Masses:
    """The masses whose pignistic probability p is that of a log-likelihood ratio L.

    tanh |L/2| = |2p - 1| stands for the side that it speaks for, the rest is not known.

    Of the consistent sonar model these are the book's: m(Occ) = b Max_occ in region I (11.7), m(Emp) = b in
    region II (11.8).
    """
    strength = np.tanh(np.asarray(log_ratio) / 2.0)
    return Masses(np.maximum(strength, 0.0), np.maximum(-strength, 0.0), 1.0 - np.abs(strength))


def combined(one: Masses, other: Masses, policy: TotalConflict = TotalConflict.RESET) -> Combination:
    """Dempster's rule (11.9) with its weight of conflict, Con = ln(1/(1 - k)) (11.10).

    1 - k is the sum of what is not in conflict: so nothing is lost to rounding where k is nearly 1.
    """
    occupied = one.occupied * (other.occupied + other.unsure) + one.unsure * other.occupied
    empty = one.empty * (other.empty + other.unsure) + one.unsure * other.empty
    unsure = one.unsure * other.unsure
    kept = occupied + empty + unsure
    total = kept <= np.exp(-TOTAL)
    whole = np.where(total, 1.0, kept)
    conflict = np.where(total, TOTAL, np.maximum(-np.log(whole), 0.0))
    decided = _decided(one, Masses(occupied, empty, unsure), policy)
    found = (
        np.where(total, told, part / whole)
        for told, part in zip(decided, (occupied, empty, unsure), strict=True)
    )
    return Combination(Masses(*found), conflict, total)


def _decided(before: Masses, left: Masses, policy: TotalConflict) -> Masses:
    """What a total conflict leaves; `left` is what is not in conflict."""
    match policy:
        case TotalConflict.KEEP:
            return before
        case TotalConflict.YAGER:
            return Masses(left.occupied, left.empty, 1.0 - left.occupied - left.empty)
        case TotalConflict.RESET:
            nothing = np.zeros_like(left.unsure)
            return Masses(nothing, nothing, np.ones_like(left.unsure))


def floored(masses: Masses, floor: float = FLOOR) -> Masses:
    """The masses with at least `floor` for "don't know"; the others shrink in proportion."""
    low = masses.unsure < floor
    shrunk = np.where(low, (1.0 - floor) / np.where(low, masses.occupied + masses.empty, 1.0), 1.0)
    return Masses(masses.occupied * shrunk, masses.empty * shrunk, np.maximum(masses.unsure, floor))


@dataclass(frozen=True, slots=True)
class Rule:
    """How evidence is combined."""

    floor: float = FLOOR
    policy: TotalConflict = TotalConflict.RESET

    def __post_init__(self) -> None:
        if not 0.0 <= self.floor < 1.0:
            raise ValueError('the floor of "don\'t know" is at least 0 and below 1')


USUAL = Rule()


class DempsterShaferGrid:
    """Dempster's rule (11.9), cell by cell.

    The masses of the consistent form are the book's (11.7, 11.8). Those of the printed form are not: it
    speaks for the wrong side at long range.
    """

    def __init__(
        self, geometry: GridGeometry, model: SonarModel, no_echo: NoEcho, rule: Rule = USUAL
    ) -> None:
        self.geometry = geometry
        self.occupied: Layer = np.zeros(geometry.shape, np.float32)
        """(rows, cols) m(Occ), row 0 = south."""
        self.empty: Layer = np.zeros(geometry.shape, np.float32)
        """(rows, cols) m(Emp)."""
        self.conflict: Layer = np.zeros(geometry.shape, np.float32)
        """(rows, cols) nats, the running sum of Con."""
        self.total_conflicts = 0
        """How often a policy had to decide on a cell."""
        self._seen: NDArray[np.bool_] = np.zeros(geometry.shape, np.bool_)
        self._model = model
        self._no_echo = no_echo
        self._rule = rule

    def update(self, sounding: Sounding) -> Patch | None:
        """Fuse one ping; the patch that it touched, None if it said nothing."""
        cone = cast(self.geometry, self._model.believed(sounding))
        return cone.patch if self._fuse(cone) else None

    def _fuse(self, cone: Cone) -> bool:
        """Whether the cone said anything."""
        said = evidence(cone, self._model, self._no_echo)
        speaks = np.abs(said) > WHISPER
        at = cone.rows[speaks], cone.cols[speaks]
        found = combined(self._masses(at), simple_support(said[speaks]), self._rule.policy)
        occupied, empty, _ = floored(found.masses, self._rule.floor)
        self.occupied[at], self.empty[at] = occupied, empty
        self.conflict[at] += found.conflict.astype(np.float32)
        self.total_conflicts += int(np.count_nonzero(found.total))
        self._seen[at] = True
        return bool(speaks.any())

    def _masses(self, at: tuple[NDArray[np.intp], NDArray[np.intp]]) -> Masses:
        occupied, empty = self.occupied[at].astype(np.float64), self.empty[at].astype(np.float64)
        return Masses(occupied, empty, np.maximum(1.0 - occupied - empty, 0.0))

    def belief(self) -> Layer:
        """(rows, cols) Bel(Occ) = m(Occ): what speaks for an obstacle."""
        return self.occupied.copy()

    def plausibility(self) -> Layer:
        """(rows, cols) Pl(Occ) = 1 - m(Emp): what does not speak against one."""
        return 1.0 - self.empty

    def layers(self) -> dict[str, Layer]:
        """(rows, cols) each: the maps that no other theory has."""
        return {
            "belief": self.belief(),
            "plausibility": self.plausibility(),
            "conflict": self.conflict.copy(),
        }

    def occupancy(self) -> Layer:
        """(rows, cols) BetP(Occ) = m(Occ) + m(dk)/2, row 0 = south; 0.5 where unknown."""
        return (1.0 + self.occupied - self.empty) / np.float32(2.0)

    def unknown(self) -> NDArray[np.bool_]:
        """(rows, cols) True where no ping has spoken."""
        return ~self._seen

    def copy(self) -> Self:
        """An independent twin."""
        twin = type(self)(self.geometry, self._model, self._no_echo, self._rule)
        twin.occupied, twin.empty = self.occupied.copy(), self.empty.copy()
        twin.conflict, twin._seen = self.conflict.copy(), self._seen.copy()
        twin.total_conflicts = self.total_conflicts
        return twin
