"""What became of a drive."""

from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from echogrid.emulation.plant import Contact

MOVING_M_S = 0.05
"""Who is slower stands: then others run into it."""
NEAR_MISS_M = 0.05
_PASSED_M = 0.1
"""m: then a near miss is over."""


@dataclass(frozen=True, slots=True)
class Bump:
    """A contact, and what it counts as."""

    at_s: float
    what: str
    """"wall", "post" or "person"."""
    speed: float
    """m/s."""
    counts_as: str
    """"collision", "undetectable", or "standing" if something came to a robot that stood."""

    @classmethod
    def judged(cls, contact: Contact, could_be_heard: bool) -> "Bump":
        """A contact with something that the robot could have heard, or not."""
        moving = contact.speed > MOVING_M_S
        kind = ("collision" if could_be_heard else "undetectable") if moving else "standing"
        return cls(contact.stamp_ns * 1e-9, contact.touched.kind, contact.speed, kind)


@dataclass(frozen=True, slots=True)
class Verdict:
    """The figures of one drive."""

    outcome: str
    """"reached", "stuck" or "late"."""
    time_s: float
    travelled: float
    """m."""
    shortest: float
    """m: of the shortest way."""
    time_ratio: float
    """How many times as long it took as the shortest way at full speed."""
    goal_error: float
    """m: how far from the goal it was in truth when it was over."""
    least_clearance: float
    """m."""
    low_clearance: float
    """m: one in a hundred moments had less."""
    near_misses: int
    reversals: int
    """How often it changed between forward and backward."""
    latency_s: tuple[float, float]
    """From where the sound met the obstacle to the command that heeds it: median, and 99 in 100 are less."""
    pings: int
    """Readings that the pilot got."""
    digest: str
    """Of all that happened."""
    bumps: tuple[Bump, ...] = ()

    @property
    def reached(self) -> bool:
        """Whether it got to the goal in time."""
        return self.outcome == "reached"

    @property
    def spl(self) -> float:
        """Success weighted by path length: S l*/max(l, l*) (Anderson et al. 2018)."""
        return self.shortest / max(self.travelled, self.shortest) if self.reached else 0.0

    @property
    def failed(self) -> bool:
        """Whether it is worth a closer look."""
        return not self.reached or self.count("collision") > 0

    def count(self, kind: str) -> int:
        """How many contacts count as that."""
        return sum(bump.counts_as == kind for bump in self.bumps)

    def as_dict(self) -> dict[str, Any]:
        """For a line of JSON."""
        return asdict(self)

    @classmethod
    def of(cls, table: dict[str, Any]) -> "Verdict":
        """From a line of JSON."""
        bumps = tuple(Bump(**bump) for bump in table["bumps"])
        first, last = table["latency_s"]
        return cls(**{**table, "bumps": bumps, "latency_s": (first, last)})


@dataclass(slots=True)
class Watch:
    """Keeps what is measured on the way, at each of the pilot's steps."""

    clearances: list[float] = field(default_factory=list)
    latencies_ns: list[int] = field(default_factory=list)
    near_misses: int = 0
    reversals: int = 0
    _near: bool = False
    _forward: bool = True

    def see(self, clearance: float, speed: float) -> None:
        """How far the nearest thing is, m, and how fast the robot goes, m/s."""
        self.clearances.append(max(clearance, 0.0))
        if abs(speed) <= MOVING_M_S:
            return
        if (speed > 0.0) is not self._forward:
            self._forward = not self._forward
            self.reversals += 1
        if 0.0 < clearance < NEAR_MISS_M and not self._near:
            self._near = True
            self.near_misses += 1
        elif clearance > _PASSED_M:
            self._near = False

    def clearance(self) -> tuple[float, float]:
        """m: the least, and that of one in a hundred moments."""
        return min(self.clearances), float(np.percentile(self.clearances, 1.0))

    def latency_s(self) -> tuple[float, float]:
        """s: the median, and what 99 in 100 are below; 0 if nothing was heard."""
        if not self.latencies_ns:
            return 0.0, 0.0
        middle, high = np.percentile(self.latencies_ns, (50.0, 99.0))
        return float(middle) * 1e-9, float(high) * 1e-9
