"""EERUF (Borenstein & Koren 1995): delays that change from cycle to cycle, for each ranger in its own way.

Ranger i hears j's ping as if from (c/2) (L/c + t_j - t_i). If t_j - t_i is another in each cycle, that
distance jumps, while an echo stays where it is. Two delays in turn are enough for this, and the book has two.
Here are three, of which no two agree for any pair: so readings can be compared, too, when one between them
was lost or was spent on listening.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations, product
from math import ceil, floor

PATTERNS = 3
AUDIBLE_NS = 40_000_000
"""How long a ping is heard: 14 m there and back."""
MOST_STEPS = 32
"""Of a delay; then there are none."""

_PAIRS = tuple(combinations(range(PATTERNS), 2))
_Steps = tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Seat:
    """What a ranger's delays depend on."""

    offset_ns: int
    """Its turn's time in the cycle."""
    bus: str
    held_ns: int
    """How long its command holds the bus: two at once would wait for each other."""


@lru_cache(maxsize=4)
def delays(seats: tuple[Seat, ...], period_ns: int, step_ns: int) -> tuple[tuple[int, ...], ...] | None:
    """Each ranger's delays (ns), one for each cycle in rotation; None: there are none.

    They are multiples of `step_ns`, so the differences t_j - t_i of any pair change by as much at least from
    one cycle to another of PATTERNS in a row. Of those that are found the longest delay is the shortest.
    """
    for most in range(_fewest(seats, step_ns), MOST_STEPS + 1):
        chosen = _chosen(seats, period_ns, step_ns, most)
        if len(chosen) == len(seats):
            return tuple(tuple(step * step_ns for step in steps) for steps in chosen)
    return None


def _fewest(seats: Sequence[Seat], step_ns: int) -> int:
    """Steps without which it can't be done: as many differences between two delays as there are rangers, and
    those that would fire at once on one bus one after the other."""
    queues = (
        (sum((other.bus, other.offset_ns) == (seat.bus, seat.offset_ns) for other in seats) - 1)
        * ceil(seat.held_ns / step_ns)
        for seat in seats
    )
    return max([len(seats) // 2, *queues])


def _chosen(seats: Sequence[Seat], period_ns: int, step_ns: int, most: int) -> list[_Steps]:
    """Delays of up to `most` steps for as many rangers as it goes: each has the first that are left to it."""
    every = product(range(most + 1), repeat=PATTERNS)
    candidates = sorted(every, key=lambda steps: (max(steps), sum(steps), steps))
    chosen: list[_Steps] = []
    for seat in seats:
        taken = _Taken()
        for other, steps in zip(seats, chosen, strict=False):
            for shift in (-1, 0, 1):
                lag_ns = shift * period_ns + other.offset_ns - seat.offset_ns
                if shift == 0 or abs(lag_ns) <= AUDIBLE_NS:
                    turned = steps[shift:] + steps[:shift]
                    taken.take(turned, lag_ns / step_ns, _held_ns(seat, other) / step_ns)
        if (first := next(filter(taken.leaves, candidates), None)) is None:
            break
        chosen.append(first)
    return chosen


def _held_ns(seat: Seat, other: Seat) -> int:
    """How far apart their commands must be."""
    return max(seat.held_ns, other.held_ns) if seat.bus == other.bus else 0


class _Taken:
    """What a ranger's delays may not be, for those of the others."""

    def __init__(self) -> None:
        self._differences: list[set[int]] = [set() for _ in _PAIRS]
        self._steps: list[set[int]] = [set() for _ in range(PATTERNS)]

    def take(self, steps: _Steps, lag: float, held: float) -> None:
        """Another one has these delays; its turns are `lag` steps later, and must be `held` steps away."""
        for differences, (a, b) in zip(self._differences, _PAIRS, strict=True):
            differences.add(steps[a] - steps[b])
        for taken, step in zip(self._steps, steps, strict=True):
            taken.update(range(floor(step + lag - held) + 1, ceil(step + lag + held)))

    def leaves(self, steps: _Steps) -> bool:
        """Whether it may have these delays."""
        return all(
            steps[a] - steps[b] not in differences
            for differences, (a, b) in zip(self._differences, _PAIRS, strict=True)
        ) and all(step not in taken for taken, step in zip(self._steps, steps, strict=True))
