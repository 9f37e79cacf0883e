"""The books: every range reading is fused, dropped for a reason, or waiting."""

from collections import Counter
from dataclasses import dataclass, field

from echogrid.drivers.readings import Outcome


@dataclass(slots=True)
class Ledger:
    """Counts of range readings. produced = fused + dropped + waiting, always."""

    outcomes: Counter[str] = field(default_factory=Counter)
    """Produced, by outcome."""
    fused: int = 0
    dropped: Counter[str] = field(default_factory=Counter)
    """By reason."""

    @property
    def produced(self) -> int:
        """All readings so far."""
        return self.outcomes.total()

    def produce(self, outcome: Outcome) -> None:
        """Enter a reading."""
        self.outcomes[outcome.value] += 1

    def drop(self, reason: str) -> None:
        """A reading will not be fused."""
        self.dropped[reason] += 1

    def balances(self, waiting: int) -> bool:
        """Whether no reading was lost or counted twice."""
        return self.produced == self.fused + self.dropped.total() + waiting
