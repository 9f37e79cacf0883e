"""The keys of a CiA 402 drive in a config file."""

from dataclasses import dataclass
from typing import Literal

from echogrid.drivers.limits import require_between

COUNTER_BITS = 32
MOST_UNITS = 1e9
"""Counts for a turn, or units of speed for one turn a second."""


@dataclass(frozen=True, slots=True)
class Cia402Settings:
    """How one axis is found, set up and read."""

    counts_per_turn: float
    """What 6064h goes up by in a turn of the motor."""
    node: int = 1
    velocity_units: float = 0.0
    """What 606Ch and 60FFh are at one turn of the motor a second; 0: counts per second."""
    range_counts: int = 0
    """After so many counts the position wraps (607Bh); 0: at the end of its 32 bits."""
    tpdo: int = 2
    """Number of the TPDO with 6064h and 606Ch."""
    status_tpdo: int = 1
    """Number of the TPDO with 6041h."""
    rpdo: int = 1
    """Number of the RPDO with 6040h and 60FFh; untouched without commands."""
    period_ms: int = 10
    """From position to position."""
    sync: Literal["off", "produce", "expect"] = "off"
    """Whether positions follow the bus's SYNC, and whether this device sends it: one on a bus does."""
    heartbeat_ms: int = 100
    """From heartbeat to heartbeat of the drive."""
    master: int = 127
    """Our own node, whose heartbeat the drive listens to while it is commanded."""
    configure: bool = True
    """Whether the drive is set up and started; if not, it must do by itself what is said here."""

    def __post_init__(self) -> None:
        require_between("counts_per_turn", self.counts_per_turn, 1.0, MOST_UNITS)
        require_between("node", self.node, 1, 127)
        require_between("velocity_units", self.velocity_units, 0.0, MOST_UNITS)
        if self.range_counts:
            require_between("range_counts", self.range_counts, 16, 1 << COUNTER_BITS)
        for key, number in (("tpdo", self.tpdo), ("status_tpdo", self.status_tpdo), ("rpdo", self.rpdo)):
            require_between(key, number, 1, 4)
        require_between("period_ms", self.period_ms, 1, 250)
        require_between("heartbeat_ms", self.heartbeat_ms, 10, 2000)
        require_between("master", self.master, 1, 127)
        if self.tpdo == self.status_tpdo:
            raise ValueError(f"tpdo and status_tpdo are both {self.tpdo}: expected two different ones")
        if self.master == self.node:
            raise ValueError(f"master and node are both {self.node}: expected two different ones")

    @property
    def modulus(self) -> int:
        """Counts from one wrap to the next."""
        return self.range_counts or 1 << COUNTER_BITS

    @property
    def units_per_turn(self) -> float:
        """Of velocity, for a turn a second."""
        return self.velocity_units or self.counts_per_turn
