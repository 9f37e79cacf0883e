"""The local grid: a window that moves with the robot, forgets, and sees what moves."""

from itertools import groupby
from math import exp, floor, inf, nan, radians, tau
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.bayes import MILLI, BayesGrid
from echogrid.mapping.cone import Cone, Reach
from echogrid.mapping.cones import Cones, cast_all
from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger, effective_tolerance
from echogrid.mapping.rolling import shifted
from echogrid.mapping.sonar_model import Form, NoEcho, silent_reach
from echogrid.mapping.walls import Walls

_LIMIT = 2.0
"""nats: a few contrary pings turn a cell over."""
_FADE_EVERY_NS = 250_000_000
_ASIDE = radians(15.0)
"""A smooth wall is heard at right angles: what answered one way is not gone because it is silent another."""
_EXPECTED = 1200
"""Milli-nats of a wall that is expected to go on: an obstacle, for some three seconds."""

Mask = NDArray[np.bool_]


class _Ping(NamedTuple):
    transducer: Pose
    ranger: Ranger
    echo: float | None
    """m."""
    stamp_ns: int
    known: bool
    """Whether the echo is that of a wall that is known: it tells of what is before it only."""

    @property
    def kind(self) -> tuple[bool, float, float, float, str]:
        """Pings for which this is equal are weighed alike."""
        ranger = self.ranger
        detection = -1.0 if ranger.detection is None else ranger.detection
        silence = ranger.no_echo.value if ranger.no_echo else ""
        return self.echo is None, ranger.half_angle, ranger.farthest, detection, silence


class LocalGrid:
    """Consistent Bayes, clamped at +-2 nats, in the odom frame, `cells` on a side, the robot in its midst.

    Evidence fades with the time constant `fade_s`.

    What has answered a ranger is held against the silence of rangers that look there another way, and a wall
    is expected to go on (walls.py): the echoes of smooth things come back at right angles only.

    Pings wait until somebody looks, and are fused then: several at once cost little more than one.
    """

    def __init__(
        self, resolution: float, cells: int, tolerance: float, fade_s: float, no_echo: NoEcho
    ) -> None:
        self._corner = (-(cells // 2), -(cells // 2))
        geometry = _window(self._corner, resolution, cells)
        self._grid = BayesGrid(geometry, _LIMIT, Form.CONSISTENT, no_echo)
        self._seen_ns: NDArray[np.int64] = np.zeros(geometry.shape, np.int64)
        self._axis: NDArray[np.float64] = np.zeros(geometry.shape, np.float64)
        """rad: from which direction each cell last answered."""
        self._walls = Walls()
        self._tolerance = tolerance
        self._no_echo = no_echo
        self._fade_s = fade_s
        self._faded_ns: int | None = None
        self._waiting: list[_Ping] = []

    @property
    def geometry(self) -> GridGeometry:
        """Where the window is now (odom frame)."""
        return self._grid.geometry

    @property
    def grid(self) -> BayesGrid:
        """What is believed now; only until the next ping."""
        if self._waiting:
            self._settle()
        return self._grid

    @property
    def seen_ns(self) -> NDArray[np.int64]:
        """(rows, cols) when each cell was last spoken of, 0 if never; only until the next ping."""
        if self._waiting:
            self._settle()
        return self._seen_ns

    def centre(self, robot: Pose) -> None:
        """Move the window, by whole cells, so that the robot is in its middle; what leaves is forgotten."""
        geometry = self.geometry
        half = geometry.rows // 2
        corner = (
            floor(robot.y / geometry.resolution) - half,
            floor(robot.x / geometry.resolution) - half,
        )
        shift = corner[0] - self._corner[0], corner[1] - self._corner[1]
        if shift == (0, 0):
            return
        self._corner = corner
        self._seen_ns = shifted(self.seen_ns, shift)
        self._axis = shifted(self._axis, shift)
        self._grid.move(_window(corner, geometry.resolution, geometry.rows), shift)

    def fade(self, now_ns: int) -> None:
        """Let the evidence fade up to now: L <- L exp(-dt/tau), in steps of a quarter of a second."""
        if self._faded_ns is None:
            self._faded_ns = now_ns
        elapsed_ns = now_ns - self._faded_ns
        if elapsed_ns >= _FADE_EVERY_NS:
            self._faded_ns = now_ns
            self.grid.fade(exp(-elapsed_ns * 1e-9 / self._fade_s))

    def fuse(
        self,
        transducer: Pose,
        ranger: Ranger,
        echo_distance: float | None,
        stamp_ns: int,
        known: bool = False,
    ) -> None:
        """Fuse a ping sent from `transducer` (odom frame). The echo of a `known` wall tells what is
        before it: where the wall stands is known better."""
        if echo_distance is not None or (ranger.no_echo or self._no_echo) is not NoEcho.IGNORE:
            self._waiting.append(_Ping(transducer, ranger, echo_distance, stamp_ns, known))

    def build(self, walls: NDArray[np.float64], now_ns: int) -> None:
        """Walls that are known to stand at points (n, 2; odom frame)."""
        geometry = self.geometry
        cols = np.floor((walls[:, 0] - geometry.x) / geometry.resolution).astype(np.intp)
        rows = np.floor((walls[:, 1] - geometry.y) / geometry.resolution).astype(np.intp)
        inside = (rows >= 0) & (rows < geometry.rows) & (cols >= 0) & (cols < geometry.cols)
        cells = (rows * geometry.cols + cols)[inside]
        self.grid.log_odds.put(cells, round(_LIMIT * MILLI))
        self.seen_ns.put(cells, now_ns)

    def vacate(self, cells: NDArray[np.intp]) -> None:
        """Nothing stands in these cells (row * columns + column): the robot does."""
        log_odds = self.grid.log_odds
        log_odds.put(cells, np.minimum(log_odds.take(cells), 0))

    def _settle(self) -> None:
        """Fuse the pings that wait. What does not depend on their order is reckoned for all at once."""
        waiting, self._waiting = self._waiting, []
        order = sorted(range(len(waiting)), key=[ping.kind for ping in waiting].__getitem__)
        pings = [waiting[number] for number in order]
        bands = [self._band(ping) for ping in pings]
        beams = [(ping.transducer, self._reach(ping, band)) for ping, band in zip(pings, bands, strict=True)]
        begins = [inf if ping.echo is None else ping.echo - bands[n] for n, ping in enumerate(pings)]
        cones = cast_all(self.geometry, beams)
        occupied = cones.distance >= np.array(begins).take(cones.ping)
        milli_nats = self._weighed(pings, cones, occupied)
        for number in sorted(range(len(order)), key=order.__getitem__):
            part = slice(cones.borders[number], cones.borders[number + 1])
            self._add(pings[number], cones.cells[part], occupied[part], milli_nats[part])

    def _band(self, ping: _Ping) -> float:
        """m: half the thickness of where its obstacle is."""
        tolerance = self._tolerance if ping.ranger.tolerance is None else ping.ranger.tolerance
        echo = ping.ranger.farthest if ping.echo is None else ping.echo
        return effective_tolerance(tolerance, self.geometry.resolution, echo)

    def _reach(self, ping: _Ping, band: float) -> Reach:
        """How far it speaks."""
        ranger = ping.ranger
        if ping.echo is not None:
            return Reach(ranger.half_angle, ping.echo + band)
        weak = (ranger.no_echo or self._no_echo) is NoEcho.WEAK
        return silent_reach(ranger) if weak else Reach(ranger.half_angle, ranger.farthest)

    def _weighed(self, pings: list[_Ping], cones: Cones, occupied: Mask) -> NDArray[np.int32]:
        """(n,) what they are worth to their cells. Those of one kind, side by side, are weighed as one."""
        parts = []
        for _, group in groupby(range(len(pings)), key=lambda number: pings[number].kind):
            numbers = list(group)
            part, ping = slice(cones.borders[numbers[0]], cones.borders[numbers[-1] + 1]), pings[numbers[0]]
            cone = Cone(
                (slice(0, self.geometry.rows), slice(0, self.geometry.cols)),
                self.geometry,
                cones.cells[part],
                cones.distance[part],
                cones.bearing[part],
                occupied[part],
                ping.echo is not None,
                ping.ranger,
                nan,  # each has its own, and the local grid's model does not ask for it
            )
            parts.append(self._grid.weigh(cone))
        return np.concatenate(parts)

    def _add(
        self, ping: _Ping, cells: NDArray[np.intp], occupied: Mask, milli_nats: NDArray[np.int32]
    ) -> None:
        """Add what a ping is worth, and remember when, and from where its obstacle answered."""
        yaw, stamp_ns = ping.transducer.yaw, ping.stamp_ns
        held = self._held(cells, occupied, yaw)
        if held is not None:
            milli_nats[held] = 0
        if ping.known:
            milli_nats[occupied] = 0
        spoken = self._grid.add(cells, milli_nats)
        self._seen_ns.put(spoken, np.maximum(self._seen_ns.take(spoken), stamp_ns))
        if ping.echo is None or ping.known:
            return
        self._axis.put(cells[occupied], yaw)
        for x, y in self._walls.beyond(ping.transducer, ping.ranger, ping.echo, stamp_ns):
            self._expect(x, y, yaw, stamp_ns)

    def _expect(self, x: float, y: float, yaw: float, stamp_ns: int) -> None:
        """Take an obstacle for likely that nobody has heard yet."""
        geometry = self.geometry
        row = floor((y - geometry.y) / geometry.resolution)
        col = floor((x - geometry.x) / geometry.resolution)
        if 0 <= row < geometry.rows and 0 <= col < geometry.cols:
            self._grid.log_odds[row, col] = max(self._grid.log_odds[row, col], _EXPECTED)
            self._axis[row, col] = yaw
            self._seen_ns[row, col] = max(self._seen_ns[row, col], stamp_ns)

    def _held(self, cells: NDArray[np.intp], occupied: Mask, yaw: float) -> NDArray[np.intp] | None:
        """The places of the cells that answered from another direction, from which this ping says nothing."""
        (answered,) = ((self._grid.log_odds.take(cells) > 0) & ~occupied).nonzero()
        if not len(answered):
            return None
        away = self._axis.take(cells.take(answered)) - yaw
        away -= tau * np.rint(away / tau)
        return answered[np.abs(away) > _ASIDE]


def _window(corner: tuple[int, int], resolution: float, cells: int) -> GridGeometry:
    """The square window whose south-western cell has these row and column numbers, counted from (0, 0)."""
    return GridGeometry(resolution, corner[1] * resolution, corner[0] * resolution, cells, cells)
