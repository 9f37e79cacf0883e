"""The obstacle sensor which is read instead of the sonars: sectors of the local grid around the robot."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from math import inf, pi

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.bayes import MILLI
from echogrid.mapping.free_path import STANDING, UNSEEN, FreePath
from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.pose import Pose, wrap_angle
from echogrid.mapping.twist import Twist
from echogrid.mapping.unknown import Unknown

_ROUNDING = 1e-9
"""rad: a sector on the border of "ahead" is ahead on both sides."""


_EMPTY = 1.0 / (1.0 + np.exp(np.arange(1 << 16, dtype=np.uint16).view(np.int16) / MILLI))
"""P(Empty) by milli-nats; those below 0 count from the end."""


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
    confidence: float = 0.0
    """0...1: how probably that obstacle is there; if there is none, the mean probability that its cells are
    empty, where those count nothing which were not spoken of lately."""
    age_ns: int | None = None
    """Since the nearest obstacle, or else any of its cells, was spoken of; None: never."""
    seen: float = 0.0
    """0...1: the part of its cells that was spoken of lately. The rest lies between the rangers' cones, or
    behind an obstacle."""


_DOUBTFUL = frozenset({SectorState.UNKNOWN, SectorState.STALE})


class StopReason(Enum):
    """Why the way ahead may not be driven, the worst first."""

    NEAR = "near"
    """Something within the stop distance, by the grid or by an echo, in the way, or about to be here."""
    SILENT = "silent"
    """A ranger that looks ahead says nothing any more."""
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
    unknown: Unknown = Unknown.BLOCKED
    """What is made of that which is unknown or stale."""
    path: FreePath = UNSEEN
    """The way of the commanded twist."""
    silent: tuple[str, ...] = ()
    """Rangers that look ahead and say nothing."""
    age_ns: int | None = None
    """Since the newest sound was heard, or none, that it rests upon; None: never."""
    latency_ns: int = 0
    """From a sound's echo to a command that heeds it, as the limit allows for it."""

    @property
    def speed_limit(self) -> float:
        """m/s of the point of the robot that moves fastest, along its way; 0 if it must stop."""
        return 0.0 if self.stop else self.path.limit

    @property
    def allowed(self) -> Twist:
        """What of the commanded twist may be driven."""
        return STANDING if self.stop else self.path.allowed

    @property
    def stop(self) -> bool:
        """Whether the robot must stop for what is ahead, or may be."""
        return self.reason is not None

    @property
    def nearest(self) -> Sector:
        """The sector with the nearest obstacle."""
        return min(self.sectors, key=lambda sector: sector.nearest)


@dataclass(frozen=True, slots=True)
class Ahead:
    """What the sectors ahead say to whoever drives there."""

    reason: StopReason | None
    """Why it must stop, if it must."""
    doubtful: bool
    """Whether any of them is unknown or stale."""


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
    unknown: Unknown = Unknown.BLOCKED
    """Whether what is unknown or stale ahead stops."""


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
        self._flat = self._rows * cells + self._cols
        self._turns_per_rad = sight.sectors / (2.0 * pi)
        self._turns = np.arctan2(offsets[self._rows], offsets[self._cols]) * self._turns_per_rad
        self._bearings = [wrap_angle(2.0 * pi * k / sight.sectors) for k in range(sight.sectors)]
        self._is_ahead = np.abs(self._bearings) <= sight.ahead + _ROUNDING
        """(sectors,)"""

    def view(self, local: LocalGrid, robot: Pose, now_ns: int) -> ObstacleView:
        """The sectors around the robot (its pose in the odom frame) now."""
        sight, count = self._sight, self._sight.sectors
        sector = self._sectors(robot.yaw)
        log_odds, seen_ns = local.grid.log_odds.take(self._flat), local.seen_ns.take(self._flat)
        known, recent = self._parts(sector, seen_ns, now_ns)
        lately = seen_ns > now_ns - sight.stale_ns
        total = np.maximum(np.bincount(sector, minlength=count), 1)
        empty = np.bincount(sector, np.where(lately, _EMPTY[log_odds], 0.0), count) / total
        newest_ns = np.zeros(count, np.int64)
        np.maximum.at(newest_ns, sector, seen_ns)
        nearest, cell = self._nearest(local, robot, sector)
        found = cell >= 0
        sure = np.where(found, 1.0 - _EMPTY[log_odds[cell]], empty)
        told_ns = np.where(found, seen_ns[cell], newest_ns)
        sectors = tuple(
            Sector(
                bearing,
                self._state(known[k], recent[k], nearest[k]),
                float(nearest[k]),
                float(sure[k]),
                max(now_ns - int(told_ns[k]), 0) if told_ns[k] else None,
                float(recent[k]),
            )
            for k, bearing in enumerate(self._bearings)
        )
        ahead = self._judged([sectors[k] for k in np.flatnonzero(self._is_ahead)])
        return ObstacleView(now_ns, sectors, ahead.reason, sight.unknown)

    def ahead(self, local: LocalGrid, robot: Pose, now_ns: int) -> Ahead:
        """What the view says of the sectors ahead, for less than a view costs."""
        sector = self._sectors(robot.yaw)
        chosen = np.flatnonzero(self._is_ahead[sector])
        sector, flat = sector[chosen], self._flat[chosen]
        known, recent = self._parts(sector, local.seen_ns.take(flat), now_ns)
        hits = np.flatnonzero(local.grid.log_odds.take(flat) >= self._sight.occupied * MILLI)
        nearest = np.full(self._sight.sectors, inf)
        np.minimum.at(nearest, sector[hits], self._distances(local, robot, chosen[hits]))
        return self._judged(
            [
                Sector(self._bearings[k], self._state(known[k], recent[k], nearest[k]), float(nearest[k]))
                for k in np.flatnonzero(self._is_ahead)
            ]
        )

    def _sectors(self, yaw: float) -> NDArray[np.intp]:
        """(n,) The sector of each cell within the horizon."""
        return np.floor(self._turns - (yaw * self._turns_per_rad - 0.5)).astype(np.intp) % self._sight.sectors

    def _parts(
        self, sector: NDArray[np.intp], seen_ns: NDArray[np.int64], now_ns: int
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(sectors,) The parts of these cells that were spoken of ever, and lately."""
        count = self._sight.sectors
        total = np.maximum(np.bincount(sector, minlength=count), 1)
        lately = seen_ns > now_ns - self._sight.stale_ns
        return np.bincount(sector, seen_ns > 0, count) / total, np.bincount(sector, lately, count) / total

    def _distances(self, local: LocalGrid, robot: Pose, cells: NDArray[np.intp]) -> NDArray[np.float64]:
        """(n,) m, of cells within the horizon, exactly."""
        geometry = local.geometry
        dx = geometry.x + (self._cols[cells] + 0.5) * geometry.resolution - robot.x
        dy = geometry.y + (self._rows[cells] + 0.5) * geometry.resolution - robot.y
        result: NDArray[np.float64] = np.hypot(dx, dy)
        return result

    def _nearest(
        self, local: LocalGrid, robot: Pose, sector: NDArray[np.intp]
    ) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
        """(sectors,) The nearest obstacle's distance in each, and its cell; inf and -1 without one."""
        nearest, cell = np.full(self._sight.sectors, inf), np.full(self._sight.sectors, -1, np.intp)
        hits = np.flatnonzero(local.grid.log_odds.take(self._flat) >= self._sight.occupied * MILLI)
        distance = self._distances(local, robot, hits)
        far_to_near = np.argsort(-distance, kind="stable")
        ordered = hits[far_to_near]  # of values for one place the last stays
        nearest[sector[ordered]], cell[sector[ordered]] = distance[far_to_near], ordered
        return nearest, cell

    def _state(self, known: float, recent: float, nearest: float) -> SectorState:
        """Of a sector of whose cells these parts were ever, and lately, spoken of."""
        if nearest < inf:
            return SectorState.BLOCKED if recent > 0.0 else SectorState.STALE
        if known < self._sight.known:
            return SectorState.UNKNOWN
        return SectorState.CLEAR if recent >= self._sight.known else SectorState.STALE

    def _judged(self, ahead: Sequence[Sector]) -> Ahead:
        """What comes of the sectors ahead."""
        states = {sector.state for sector in ahead}
        reason = None
        if any(sector.nearest <= self._sight.stop_distance for sector in ahead):
            reason = StopReason.NEAR
        elif self._sight.unknown is Unknown.BLOCKED and SectorState.UNKNOWN in states:
            reason = StopReason.UNKNOWN
        elif self._sight.unknown is Unknown.BLOCKED and SectorState.STALE in states:
            reason = StopReason.STALE
        return Ahead(reason, not _DOUBTFUL.isdisjoint(states))
