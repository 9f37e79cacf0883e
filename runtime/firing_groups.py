"""Which rangers may fire at one time, by the angles at which they are mounted."""

from collections.abc import Iterable, Sequence
from itertools import pairwise, permutations
from math import gcd, pi, tau

from echogrid.mapping.pose import wrap_angle

_ROUNDING = 1e-9
"""rad: 90 degrees are enough where 90 are asked for."""
_PATIENCE = 20_000
"""Steps of the search for a partition into so many groups: then another group is opened."""
_TRIED_OUT = 8
"""Groups of which every order is looked at."""

Groups = tuple[tuple[int, ...], ...]


def angle_between(one: float, other: float) -> float:
    """rad, 0 to pi."""
    return abs(wrap_angle(one - other))


def grouped(bearings: Sequence[float], separation: float) -> Groups:
    """Indices of the bearings (rad), in as few groups as there are with `separation` between any two of one.

    They come in the order in which the smallest angle between a group and the next is largest, and then the
    sum of these angles. The first bearing is in the first group; the same bearings give the same groups.
    """
    around = sorted(range(len(bearings)), key=lambda index: (bearings[index] % tau, index))
    clashes = [
        {j for j, other in enumerate(bearings) if angle_between(one, other) < separation - _ROUNDING}
        for one in bearings
    ]
    count = max((_crowd(bearings, one, separation) for one in bearings), default=0)
    while (found := _Partition(around, clashes, count).groups()) is None:
        count += 1
    return _in_turn(sorted(tuple(sorted(group)) for group in found), bearings)


def _crowd(bearings: Iterable[float], first: float, separation: float) -> int:
    """How many there are from that bearing on, counter-clockwise, of which each needs a group of its own."""
    turns = ((other - first + _ROUNDING) % tau for other in bearings)
    return sum(turn < separation - _ROUNDING for turn in turns)


class _Partition:
    """The search for a partition into so many groups: around the circle, each into the group behind that of
    the one before if it may, and back if there is none for it."""

    def __init__(self, around: Sequence[int], clashes: Sequence[set[int]], count: int) -> None:
        self._around = around
        self._clashes = clashes
        self._groups: list[list[int]] = [[] for _ in range(count)]
        self._steps = 0

    def groups(self) -> list[list[int]] | None:
        """The groups; None if there are none, or none was found for long."""
        return self._groups if self._placed(0, 0) else None

    def _placed(self, place: int, first: int) -> bool:
        """Whether all from that place on can be put into groups; group `first` is the first to be tried."""
        if place == len(self._around):
            return True
        self._steps += 1
        index, count = self._around[place], len(self._groups)
        for number in ((first + more) % count for more in range(count)):
            group = self._groups[number]
            if self._steps <= _PATIENCE and self._clashes[index].isdisjoint(group):
                group.append(index)
                if self._placed(place + 1, number + 1):
                    return True
                group.pop()
        return False


def _in_turn(groups: Sequence[tuple[int, ...]], bearings: Sequence[float]) -> Groups:
    """The groups in the best of the orders which are looked at."""
    numbers = range(len(groups))
    apart = [
        [min(angle_between(bearings[i], bearings[j]) for i in one for j in other) for other in groups]
        for one in groups
    ]

    def worth(order: Sequence[int]) -> tuple[float, float]:
        angles = [round(apart[a][b], 9) for a, b in pairwise([*order, *order[:1]])]
        return min(angles, default=pi), sum(angles)

    best = max(_orders(numbers), key=worth)
    return tuple(groups[number] for number in best)


def _orders(numbers: Sequence[int]) -> Iterable[tuple[int, ...]]:
    """All orders that begin with the first; of many groups those which go around by steps of one size."""
    if len(numbers) <= _TRIED_OUT:
        return ((*numbers[:1], *others) for others in permutations(numbers[1:]))
    count = len(numbers)
    strides = (stride for stride in range(1, count) if gcd(stride, count) == 1)
    return (tuple(stride * step % count for step in range(count)) for stride in strides)
