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
    path: str = "readings"
    """What goes from the emulated rangers to the robot: readings, or all bytes (paths.py)."""

    @property
    def name(self) -> str:
        """Fit for a file name."""
        crosstalk = "-crosstalk" if self.crosstalk else ""
        path = f"-{self.path}" if self.path != "readings" else ""
        return f"{self.world}-{self.seed}-{self.pilot}-{self.rig}-{self.fault}{crosstalk}{path}"

    @property
    def driver(self) -> str:
        """Who drives, and by what, for tables."""
        return self.pilot if self.path == "readings" else f"{self.pilot} by {self.path}"

    def as_dict(self) -> dict[str, str | int | bool]:
        """For a line of JSON."""
        return asdict(self)
