"""The results of trials as Markdown."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import sqrt
from statistics import fmean

from echogrid.runtime.trials.results import Line

_CERTAIN = 3.0
"""No collision in N km: fewer than 3/N in a km, at 95 % (the rule of three)."""
_QUANTILE = 1.645
"""Of the normal distribution, 95 %."""
_HEADS = (
    "drives",
    "km",
    "collisions/km (95 % below)",
    "undetectable/km",
    "near misses/km",
    "least clearance, m",
    "P1, m",
    "mean speed, m/s",
    "success (without a collision)",
    "SPL",
    "off the goal, m: mean / most",
    "stuck",
    "time ratio",
    "ping to command, ms: median / P99",
)


@dataclass(frozen=True, slots=True)
class Tally:
    """The figures of several drives together."""

    lines: Sequence[Line]

    @property
    def kilometres(self) -> float:
        """Driven."""
        return sum(line.verdict.travelled for line in self.lines) / 1000.0

    def count(self, kind: str) -> int:
        """Contacts of that kind."""
        return sum(line.verdict.count(kind) for line in self.lines)

    def bound(self) -> float:
        """Collisions in a km, 95 % below: of a Poisson process of which so many were seen."""
        return self._per_km(_most(self.count("collision")))

    def _per_km(self, number: float) -> float:
        """Of those who did not get on, as if they had gone a metre."""
        return number / max(self.kilometres, 0.001)

    def cells(self) -> Iterator[str]:
        """A row of the table."""
        verdicts = [line.verdict for line in self.lines]
        km = self.kilometres
        reached = [verdict for verdict in verdicts if verdict.reached]
        yield str(len(verdicts))
        yield f"{km:.3f}"
        yield f"{self._per_km(self.count('collision')):.1f} ({self.bound():.1f})"
        yield f"{self._per_km(self.count('undetectable')):.1f}"
        yield f"{self._per_km(sum(verdict.near_misses for verdict in verdicts)):.1f}"
        yield f"{min(verdict.least_clearance for verdict in verdicts):.3f}"
        yield f"{fmean(verdict.low_clearance for verdict in verdicts):.3f}"
        yield f"{1000.0 * km / sum(verdict.time_s for verdict in verdicts):.3f}"
        clean = sum(not verdict.failed for verdict in verdicts)
        yield f"{100.0 * len(reached) / len(verdicts):.0f} % ({100.0 * clean / len(verdicts):.0f} %)"
        yield f"{fmean(verdict.spl for verdict in verdicts):.2f}"
        off = [verdict.goal_error for verdict in reached]
        yield f"{fmean(off):.2f} / {max(off):.2f}" if off else "-"
        yield f"{100.0 * sum(verdict.outcome == 'stuck' for verdict in verdicts) / len(verdicts):.0f} %"
        yield f"{fmean(verdict.time_ratio for verdict in reached):.2f}" if reached else "-"
        middle = fmean(verdict.latency_s[0] for verdict in verdicts)
        yield f"{1000.0 * middle:.0f} / {1000.0 * max(verdict.latency_s[1] for verdict in verdicts):.0f}"


def tables(lines: Sequence[Line]) -> Iterator[str]:
    """A table for each pilot with a row for each world, and all pilots together at the end."""
    drivers = list(dict.fromkeys(line.job.driver for line in lines))
    worlds = list(dict.fromkeys(line.job.world for line in lines))
    for driver in drivers:
        of_driver = [line for line in lines if line.job.driver == driver]
        yield from _head(driver)
        for world in worlds:
            yield _row(world, [line for line in of_driver if line.job.world == world])
        yield _row("**all**", of_driver)
        yield ""
    yield from _head("all worlds")
    for driver in drivers:
        yield _row(driver, [line for line in lines if line.job.driver == driver])


def speed(lines: Sequence[Line]) -> str:
    """How fast it went: simulated seconds for one of a core."""
    simulated, cpu = sum(line.verdict.time_s for line in lines), sum(line.cpu_s for line in lines)
    pings = sum(line.verdict.pings for line in lines)
    factor, rate = simulated / max(cpu, 1e-3), pings / simulated
    times = f"{factor:.1f} times real time, {rate:.0f} readings a second"
    return f"{simulated:.0f} s simulated in {cpu:.0f} s of a core: {times}"


def _head(name: str) -> Iterator[str]:
    yield f"| {name} | {' | '.join(_HEADS)} |"
    yield "|---" * (len(_HEADS) + 1) + "|"


def _row(name: str, lines: Sequence[Line]) -> str:
    return f"| {name} | {' | '.join(Tally(lines).cells())} |"


def _most(seen: int) -> float:
    """How many could be expected at most, 95 % sure, where so many were seen: 3 for none.

    From there on Poisson's upper bound by Wilson and Hilferty's chi-square approximation (0.3 % off).
    """
    if seen == 0:
        return _CERTAIN
    degrees = seen + 1.0
    root = 1.0 - 1.0 / (9.0 * degrees) + _QUANTILE / (3.0 * sqrt(degrees))
    return degrees * root * root * root
