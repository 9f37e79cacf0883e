"""The local grid: a window that moves with the robot, forgets, and sees what moves."""

from math import exp, floor

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.bayes import BayesGrid
from echogrid.mapping.cone import cast
from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.rolling import shifted
from echogrid.mapping.sonar_model import Form, NoEcho
from echogrid.mapping.sounding import Sounding

_LIMIT = 2.0
"""nats: a few contrary pings turn a cell over."""
_FADE_EVERY_NS = 250_000_000


class LocalGrid:
    """Consistent Bayes, clamped at +-2 nats, in the odom frame, `cells` on a side, the robot in its midst.

    Evidence fades with the time constant `fade_s`. `seen_ns` (rows, cols) holds when each cell was last
    spoken of, 0 if never.
    """

    def __init__(
        self, resolution: float, cells: int, tolerance: float, fade_s: float, no_echo: NoEcho
    ) -> None:
        self._corner = (-(cells // 2), -(cells // 2))
        geometry = _window(self._corner, resolution, cells)
        self.grid = BayesGrid(geometry, _LIMIT, Form.CONSISTENT, no_echo)
        self.seen_ns: NDArray[np.int64] = np.zeros(geometry.shape, np.int64)
        self._tolerance = tolerance
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
        cone = cast(self.geometry, Sounding(transducer, ranger, echo_distance, tolerance))
        spoken = self.grid.fuse(cone)
        self.seen_ns.put(spoken, np.maximum(self.seen_ns.take(spoken), stamp_ns))


def _window(corner: tuple[int, int], resolution: float, cells: int) -> GridGeometry:
    """The square window whose south-western cell has these row and column numbers, counted from (0, 0)."""
    return GridGeometry(resolution, corner[1] * resolution, corner[0] * resolution, cells, cells)
