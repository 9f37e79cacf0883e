"""The obstacle sensor which is read instead of the sonars: sectors of the local grid around the robot."""

from dataclasses import dataclass
from enum import Enum
from math import inf, pi

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.bayes import MILLI
from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.pose import Pose, wrap_angle

_ROUNDING = 1e-9
"""rad: a sector on the border of "ahead" is ahead on both sides."""


class SectorState(Enum):
    """What is known of a sector. Only CLEAR may be driven into."""

    CLEAR = "clear"
    BLOCKED = "blocked"
    UNKNOWN = "unknown"
    STALE = "stale"


@dataclass(frozen=True, slots=True)
class Sector:
    """One direction around the robot."""

    bearing: float
    """rad, its middle, from straight ahead."""
    state: SectorState
    nearest: float
    """m from base_link to the nearest occupied cell within the horizon; inf if there is none."""


class StopReason(Enum):
    """Why the way ahead may not be driven, the worst first."""

    NEAR = "near"
    """Something within the stop distance, by the grid or by an echo."""
    UNKNOWN = "unknown"
    STALE = "stale"


@dataclass(frozen=True, slots=True)
class ObstacleView:
    """What the virtual sensor publishes each tick."""

    stamp_ns: int
    sectors: tuple[Sector, ...]
    """Counter-clockwise, the first one straight ahead."""
    reason: StopReason | None
    """Why the robot must stop, if it must."""

    @property
    def stop(self) -> bool:
        """Whether the robot must stop for what is ahead, or may be."""
        return self.reason is not None

    @property
    def nearest(self) -> Sector:
        """The sector with the nearest obstacle."""
        return min(self.sectors, key=lambda sector: sector.nearest)


@dataclass(frozen=True, slots=True)
class Sight:
    """How the local grid is read."""

    sectors: int = 16
    horizon: float = 2.0
    """m: how far it looks."""
    occupied: float = 0.85
    """nats from which a cell is an obstacle (probability 0.70)."""
    known: float = 0.3
    """The part of a sector's cells that must have been spoken of, and lately, for it to be clear."""
    stale_ns: int = 1_000_000_000
    stop_distance: float = 0.5
    """m from base_link."""
    ahead: float = pi / 4.0
    """rad: the half angle of "ahead"."""


class VirtualSensor:
    """Reads a local grid of a fixed size, whose window keeps the robot in its middle cell.

    The polar places of the window's cells are reckoned once, from the middle: they are off by half a cell
    at most. The distance of an obstacle is exact.
    """

    def __init__(self, sight: Sight, resolution: float, cells: int) -> None:
        self._sight = sight
        offsets = (np.arange(cells, dtype=np.float64) - cells // 2) * resolution
        distance = np.hypot(offsets[np.newaxis, :], offsets[:, np.newaxis])
        self._rows, self._cols = np.nonzero((distance <= sight.horizon) & (distance > 0.0))
        self._turns_per_rad = sight.sectors / (2.0 * pi)
        self._turns = np.arctan2(offsets[self._rows], offsets[self._cols]) * self._turns_per_rad

    def view(self, local: LocalGrid, robot: Pose, now_ns: int) -> ObstacleView:
        """The sectors around the robot (its pose in the odom frame) now."""
        sector = self._sectors(robot.yaw)
        seen_ns = local.seen_ns[self._rows, self._cols]
        total = np.maximum(np.bincount(sector, minlength=self._sight.sectors), 1)
        known = np.bincount(sector, seen_ns > 0, self._sight.sectors) / total
        recent = np.bincount(sector, seen_ns > now_ns - self._sight.stale_ns, self._sight.sectors) / total
        nearest = self._nearest(local, robot, sector)
        sectors = tuple(
            Sector(
                wrap_angle(2.0 * pi * k / self._sight.sectors),
                self._state(known[k], recent[k], nearest[k]),
                float(nearest[k]),
            )
            for k in range(self._sight.sectors)
        )
        return ObstacleView(now_ns, sectors, self._stop_reason(sectors))

    def _sectors(self, yaw: float) -> NDArray[np.intp]:
        """(n,) The sector of each cell within the horizon."""
        return np.floor(self._turns - (yaw * self._turns_per_rad - 0.5)).astype(np.intp) % self._sight.sectors

    def _nearest(self, local: LocalGrid, robot: Pose, sector: NDArray[np.intp]) -> NDArray[np.float64]:
        """(sectors,) The distance of the nearest obstacle in each, inf where there is none."""
        nearest = np.full(self._sight.sectors, inf)
        hits = np.flatnonzero(local.grid.log_odds[self._rows, self._cols] >= self._sight.occupied * MILLI)
        geometry = local.geometry
        dx = geometry.x + (self._cols[hits] + 0.5) * geometry.resolution - robot.x
        dy = geometry.y + (self._rows[hits] + 0.5) * geometry.resolution - robot.y
        np.minimum.at(nearest, sector[hits], np.hypot(dx, dy))
        return nearest

    def _state(self, known: float, recent: float, nearest: float) -> SectorState:
        """Of a sector of whose cells these parts were ever, and lately, spoken of."""
        if nearest < inf:
            return SectorState.BLOCKED if recent > 0.0 else SectorState.STALE
        if known < self._sight.known:
            return SectorState.UNKNOWN
        return SectorState.CLEAR if recent >= self._sight.known else SectorState.STALE

    def _stop_reason(self, sectors: tuple[Sector, ...]) -> StopReason | None:
        ahead = [sector for sector in sectors if abs(sector.bearing) <= self._sight.ahead + _ROUNDING]
        states = {sector.state for sector in ahead}
        if any(sector.nearest <= self._sight.stop_distance for sector in ahead):
            return StopReason.NEAR
        if SectorState.UNKNOWN in states:
            return StopReason.UNKNOWN
        return StopReason.STALE if SectorState.STALE in states else None
