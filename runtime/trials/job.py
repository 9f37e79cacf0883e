"""What is tried: one drive, named by what it follows from."""

from dataclasses import asdict, dataclass


@dataclass(frozen=True, slots=True, order=True)
class Job:
    """The same job gives the same bits."""

    world: str
    seed: int
    """Of start, goal, noise, slip and fault."""
    pilot: str
    rig: str = "ring-16"
    fault: str = "none"
    crosstalk: bool = False
    """Whether rangers hear each other."""

    @property
    def name(self) -> str:
        """Fit for a file name."""
        crosstalk = "-crosstalk" if self.crosstalk else ""
        return f"{self.world}-{self.seed}-{self.pilot}-{self.rig}-{self.fault}{crosstalk}"

    def as_dict(self) -> dict[str, str | int | bool]:
        """For a line of JSON."""
        return asdict(self)
