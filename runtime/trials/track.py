"""What happened on a drive, step by step."""

import hashlib
import struct
from dataclasses import dataclass, field

from echogrid.drivers.readings import RangeReading

COLUMNS = (
    "time_s",
    "x_m",
    "y_m",
    "yaw_rad",
    "odometry_x_m",
    "odometry_y_m",
    "odometry_yaw_rad",
    "asked_mps",
    "asked_rad_s",
    "clearance_m",
)
Row = tuple[float, ...]
"""Of these. The true pose is that of the map frame."""


@dataclass(slots=True)
class Track:
    """The rows, and the digest of all."""

    rows: list[Row] = field(default_factory=list)
    _sum: "hashlib._Hash" = field(default_factory=hashlib.sha256)

    def step(self, row: Row) -> None:
        """A step of whoever drives."""
        self.rows.append(row)
        self._sum.update(struct.pack(f"<{len(row)}d", *row))

    def reading(self, reading: RangeReading) -> None:
        """What a ranger said."""
        told = f"{reading.sensor} {reading.outcome.value} {reading.stamp_ns} {reading.distance.hex()}"
        self._sum.update(told.encode())

    def digest(self) -> str:
        """Of all so far."""
        return self._sum.hexdigest()[:32]
