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
