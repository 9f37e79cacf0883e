"""EERUF (Borenstein & Koren 1995): delays that change from cycle to cycle, for each ranger in its own way.

Ranger i hears j's ping as if from (c/2) (L/c + t_j - t_i). If t_j - t_i is another in each cycle, that
distance jumps, while an echo stays where it is. Two delays in turn are enough for this, and the book has two.
Here are three, of which no two agree for any pair: so readings can be compared, too, when one between them
was lost or was spent on listening.

This holds if every command goes out on time. So every turn finds its bus idle: no other command or answer
needs it then, nor are there answers that had to wait for each other.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache, lru_cache
from itertools import combinations, islice, product
from math import ceil, floor

from echogrid.drivers.pace import Span

PATTERNS = 3
AUDIBLE_NS = 40_000_000
"""How long a ping is heard: 14 m there and back."""
MOST_STEPS = 32
"""By which delays of a ranger differ; then there are none."""

_PATIENCE = 600
"""Delays of a ranger that are tried, of those which are free."""

_PAIRS = tuple(combinations(range(PATTERNS), 2))
_SHIFTS = (0, -1, 1, -2, 2)
"""Cycles, to those in which another one's turns may fall into one's own time."""
_Steps = tuple[int, ...]
_Transfer = tuple[int, int, bool]
"""From when on, for how long (ns), and whether it is a command."""


@dataclass(frozen=True, slots=True)
class Seat:
    """What a ranger's delays depend on."""

    offset_ns: int
    """Its turn's time in the cycle."""
    bus: str
    busy: tuple[Span, ...]
    """When it needs the bus, from its turn on: first for the command."""


@dataclass(frozen=True, slots=True)
class Cycle:
    """What all of them have in common."""

    period_ns: int
    step_ns: int
    """The delays are multiples of this."""
    jitter_ns: int = 0
    """So much later than another a cycle may begin."""


@lru_cache(maxsize=32)
def delays(seats: tuple[Seat, ...], cycle: Cycle) -> tuple[tuple[int, ...], ...]:
    """Delays (ns), one for each cycle in rotation, of as many of the rangers as it goes: of the first ones.

    They are multiples of the step, so the differences t_j - t_i of any pair change by as much at least from
    one cycle to another of PATTERNS in a row. Each ranger has the shortest that those before it leave.
    """
    chosen: list[_Steps] = []
    buses = {seat.bus: _Traffic(cycle) for seat in seats}
    for seat in seats:
        taken = _Taken(seat, cycle)
        for other, steps in zip(seats, chosen, strict=False):
            for shift in _SHIFTS:
                taken.take(other, steps, shift)
        traffic = buses[seat.bus]
        tried = islice(taken.left(), _PATIENCE)
        if (first := next((steps for steps in tried if traffic.is_on_time_with(seat, steps)), None)) is None:
            break
        traffic.add(seat, first)
        chosen.append(first)
    return tuple(tuple(step * cycle.step_ns for step in steps) for steps in chosen)


@cache
def _candidates() -> tuple[_Steps, ...]:
    """What delays can be, the shortest first."""
    every = product(range(MOST_STEPS + 1), repeat=PATTERNS)
    return tuple(sorted(every, key=lambda steps: (max(steps), sum(steps), steps)))


class _Taken:
    """What a ranger's delays may not be, for those of the others."""

    def __init__(self, seat: Seat, cycle: Cycle) -> None:
        self._seat = seat
        self._cycle = cycle
        self._differences: list[set[int]] = [set() for _ in _PAIRS]
        self._steps: list[set[int]] = [set() for _ in range(PATTERNS)]
        self._beside: list[tuple[_Steps, float]] = []
        """Turns of other cycles: delays, and by how many steps they are later."""

    def take(self, other: Seat, steps: _Steps, shift: int) -> None:
        """Another one has these delays; those of its turns are meant that are so many cycles later."""
        cycle = self._cycle
        turned = steps[shift:] + steps[:shift]
        lag_ns = shift * cycle.period_ns + other.offset_ns - self._seat.offset_ns
        if shift == 0:
            for differences, (a, b) in zip(self._differences, _PAIRS, strict=True):
                differences.add(turned[a] - turned[b])
        else:
            self._beside.append((turned, lag_ns / cycle.step_ns))
        if other.bus == self._seat.bus:
            self._keep_apart(other, turned, lag_ns, cycle.jitter_ns if shift else 0)

    def _keep_apart(self, other: Seat, steps: _Steps, lag_ns: int, margin_ns: int) -> None:
        """On one bus: no command may fall into a time of the other."""
        for (start_ns, end_ns), (begins_ns, ends_ns) in product(self._seat.busy, other.busy):
            if start_ns and begins_ns and not self._cycle.jitter_ns:
                continue  # One answer waits for the other; with chance nobody knows for how long.
            earliest = (lag_ns + begins_ns - end_ns - margin_ns) / self._cycle.step_ns
            latest = (lag_ns + ends_ns - start_ns + margin_ns) / self._cycle.step_ns
            for taken, step in zip(self._steps, steps, strict=True):
                taken.update(range(floor(step + earliest) + 1, ceil(step + latest)))

    def left(self) -> Iterator[_Steps]:
        """Delays that it may have: the shortest, then those of which none is shorter than so many steps."""
        room = (self._cycle.period_ns - self._cycle.jitter_ns) // self._cycle.step_ns
        for least in range(0, room, MOST_STEPS):
            free = [
                [least + step < room and least + step not in taken for step in range(MOST_STEPS + 1)]
                for taken in self._steps
            ]
            for a, b, c in _candidates():
                if free[0][a] and free[1][b] and free[2][c]:
                    steps = (least + a, least + b, least + c)
                    if self._differs(steps) and not any(self._stays(steps, *each) for each in self._beside):
                        yield steps

    def _differs(self, steps: _Steps) -> bool:
        """Whether all that is heard within a cycle jumps."""
        return all(
            steps[a] - steps[b] not in differences
            for differences, (a, b) in zip(self._differences, _PAIRS, strict=True)
        )

    def _stays(self, steps: _Steps, others: _Steps, lag: float) -> bool:
        """Whether turns of another cycle are heard, and don't jump."""
        gaps = [other - own for own, other in zip(steps, others, strict=True)]
        audible = AUDIBLE_NS / self._cycle.step_ns
        return any(gaps[a] == gaps[b] and abs(lag + gaps[a]) <= audible for a, b in _PAIRS)


class _Traffic:
    """What goes over one bus in a rotation: commands, and answers which may wait for each other."""

    def __init__(self, cycle: Cycle) -> None:
        self._cycle = cycle
        self._rotation_ns = PATTERNS * cycle.period_ns
        self._transfers: list[_Transfer] = []

    def add(self, seat: Seat, steps: _Steps) -> None:
        """Another ranger has these delays."""
        self._transfers = sorted([*self._transfers, *self._of(seat, steps)])

    def is_on_time_with(self, seat: Seat, steps: _Steps) -> bool:
        """Whether all commands find the bus idle, those of this ranger too."""
        transfers = sorted([*self._transfers, *self._of(seat, steps)])
        idle_ns = 0
        for lap_ns in (0, self._rotation_ns):
            for start_ns, lasts_ns, is_command in transfers:
                if is_command and idle_ns > lap_ns + start_ns:
                    return False
                idle_ns = max(idle_ns, lap_ns + start_ns) + lasts_ns
        return True

    def _of(self, seat: Seat, steps: _Steps) -> Iterator[_Transfer]:
        for number, step in enumerate(steps):
            turn_ns = seat.offset_ns + number * self._cycle.period_ns + step * self._cycle.step_ns
            for start_ns, end_ns in seat.busy:
                yield (turn_ns + start_ns) % self._rotation_ns, end_ns - start_ns, start_ns == 0
