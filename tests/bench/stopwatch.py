"""How long work takes."""

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter

REPEATS = 7


@dataclass(frozen=True, slots=True)
class Row:
    """One thing, and another to compare it with."""

    what: str
    each_us: float
    beside: str = ""
    beside_us: float = 0.0

    def __str__(self) -> str:
        if not self.beside:
            return f"| {self.what} | {self.each_us:.2f} | | | |"
        ratio = self.each_us / self.beside_us
        return f"| {self.what} | {self.each_us:.2f} | {self.beside} | {self.beside_us:.2f} | {ratio:.2f} |"


def least_us(work: Callable[[], int]) -> float:
    """Microseconds an item, of the quickest of several runs; `work` says how many items it did."""
    return min(_once_us(work) for _ in range(REPEATS))


def _once_us(work: Callable[[], int]) -> float:
    start = perf_counter()
    items = work()
    return (perf_counter() - start) * 1e6 / items


@dataclass(frozen=True, slots=True)
class Load:
    """What a core is busy with for something that goes on all the time."""

    what: str
    items: int
    """1/s."""
    percent: float
    """Of a core, if they come one by one."""
    at_once: float
    """The same, if they come in batches."""

    def __str__(self) -> str:
        each_us = self.percent * 1e4 / self.items
        return f"| {self.what} | {self.items} | {each_us:.1f} | {self.percent:.2f} | {self.at_once:.2f} |"
