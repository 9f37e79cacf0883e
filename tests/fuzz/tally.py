"""What comes of an ordeal."""

from dataclasses import dataclass, field


@dataclass(slots=True)
class Tally:
    """What became of a driver."""

    driver: str
    unit: str
    """What it was fed: "bytes" or "frames"."""
    fed: int = 0
    readings: int = 0
    resyncs: int = 0
    faults: list[str] = field(default_factory=list)

    def blame(self, what: str, seed: int) -> None:
        """Note what it must not do."""
        self.faults.append(f"{what} (after {self.fed} {self.unit} of seed {seed})")
