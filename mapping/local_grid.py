"""The local grid: a window that moves with the robot, forgets, and sees what moves."""

from math import exp, floor, radians, tau

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.bayes import BayesGrid
from echogrid.mapping.cone import Cone, cast
from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.rolling import shifted
from echogrid.mapping.sonar_model import Form, NoEcho, silent_reach
from echogrid.mapping.sounding import Sounding
from echogrid.mapping.walls import Walls

_LIMIT = 2.0
"""nats: a few contrary pings turn a cell over."""
_FADE_EVERY_NS = 250_000_000
_ASIDE = radians(15.0)
"""A smooth wall is heard at right angles: what answered one way is not gone because it is silent another."""
_EXPECTED = 1200
"""Milli-nats of a wall that is expected to go on: an obstacle, for some three seconds."""


class LocalGrid:
    """Consistent Bayes, clamped at +-2 nats, in the odom frame, `cells` on a side, the robot in its midst.

    Evidence fades with the time constant `fade_s`. `seen_ns` (rows, cols) holds when each cell was last
    spoken of, 0 if never.

    What has answered a ranger is held against the silence of rangers that look there another way, and a wall
    is expected to go on (walls.py): the echoes of smooth things come back at right angles only.
    """

    def __init__(
        self, resolution: float, cells: int, tolerance: float, fade_s: float, no_echo: NoEcho
    ) -> None:
        self._corner = (-(cells // 2), -(cells // 2))
        geometry = _window(self._corner, resolution, cells)
        self.grid = BayesGrid(geometry, _LIMIT, Form.CONSISTENT, no_echo)
        self.seen_ns: NDArray[np.int64] = np.zeros(geometry.shape, np.int64)
        self._axis: NDArray[np.float64] = np.zeros(geometry.shape, np.float64)
        """rad: from which direction each cell last answered."""
        self._walls = Walls()
        self._tolerance = tolerance
        self._no_echo = no_echo
        self._fade_s = fade_s
        self._faded_ns: int | None = None

    @property
    def geometry(self) -> GridGeometry:
        """Where the window is now (odom frame)."""
        return self.grid.geometry

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
        self.grid.move(_window(corner, geometry.resolution, geometry.rows), shift)
        self.seen_ns = shifted(self.seen_ns, shift)
        self._axis = shifted(self._axis, shift)

    def fade(self, now_ns: int) -> None:
        """Let the evidence fade up to now: L <- L exp(-dt/tau), in steps of a quarter of a second."""
        if self._faded_ns is None:
            self._faded_ns = now_ns
        elapsed_ns = now_ns - self._faded_ns
        if elapsed_ns >= _FADE_EVERY_NS:
            self._faded_ns = now_ns
            self.grid.fade(exp(-elapsed_ns * 1e-9 / self._fade_s))

    def fuse(self, transducer: Pose, ranger: Ranger, echo_distance: float | None, stamp_ns: int) -> None:
        """Fuse a ping sent from `transducer` (odom frame)."""
        tolerance = self._tolerance if ranger.tolerance is None else ranger.tolerance
        weak = echo_distance is None and (ranger.no_echo or self._no_echo) is NoEcho.WEAK
        cone = cast(
            self.geometry,
            Sounding(transducer, ranger, echo_distance, tolerance),
            silent_reach(ranger) if weak else None,
        )
        spoken = self.grid.fuse(cone, self._held(cone, transducer.yaw))
        self.seen_ns.put(spoken, np.maximum(self.seen_ns.take(spoken), stamp_ns))
        if echo_distance is None:
            return
        self._axis.put(cone.cells[cone.occupied], transducer.yaw)
        for x, y in self._walls.beyond(transducer, ranger, echo_distance, stamp_ns):
            self._expect(x, y, transducer.yaw, stamp_ns)

    def _expect(self, x: float, y: float, yaw: float, stamp_ns: int) -> None:
        """Take an obstacle for likely that nobody has heard yet."""
        geometry = self.geometry
        row = floor((y - geometry.y) / geometry.resolution)
        col = floor((x - geometry.x) / geometry.resolution)
        if 0 <= row < geometry.rows and 0 <= col < geometry.cols:
            self.grid.log_odds[row, col] = max(self.grid.log_odds[row, col], _EXPECTED)
            self._axis[row, col] = yaw
            self.seen_ns[row, col] = max(self.seen_ns[row, col], stamp_ns)

    def _held(self, cone: Cone, yaw: float) -> NDArray[np.intp] | None:
        """The places of the cone's cells that answered from another direction, from which this ping says
        nothing."""
        (answered,) = ((self.grid.log_odds.take(cone.cells) > 0) & ~cone.occupied).nonzero()
        if not len(answered):
            return None
        away = self._axis.take(cone.cells.take(answered)) - yaw
        away -= tau * np.rint(away / tau)
        return answered[np.abs(away) > _ASIDE]


def _window(corner: tuple[int, int], resolution: float, cells: int) -> GridGeometry:
    """The square window whose south-western cell has these row and column numbers, counted from (0, 0)."""
    return GridGeometry(resolution, corner[1] * resolution, corner[0] * resolution, cells, cells)
