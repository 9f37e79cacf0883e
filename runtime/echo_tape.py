"""The pings of a log as theories take them, and the picture of them before any theory."""

from typing import Self

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.grid import GridGeometry, Patch
from echogrid.mapping.metrics import Mask
from echogrid.mapping.pose import Pose
from echogrid.mapping.sounding import Sounding
from echogrid.runtime import offline
from echogrid.runtime.loop import SECOND_NS
from echogrid.runtime.recording import Recording
from echogrid.runtime.ring_recording import RingPing

_SLOPE_S = 0.25
"""The speed is that over so long before and after."""


class EchoTape:
    """A theory that believes nothing: it keeps the pings, and marks where on their axes the echoes end."""

    def __init__(self, geometry: GridGeometry) -> None:
        self.geometry = geometry
        self.soundings: list[Sounding] = []

    def update(self, sounding: Sounding) -> Patch | None:
        """Keep one ping; the whole of the grid."""
        self.soundings.append(sounding)
        return slice(0, self.geometry.rows), slice(0, self.geometry.cols)

    def occupancy(self) -> NDArray[np.float32]:
        """(rows, cols) 1 where an echo ends, 0.5 elsewhere."""
        return np.where(self.unknown(), 0.5, 1.0).astype(np.float32)

    def unknown(self) -> Mask:
        """(rows, cols) True where no echo ends."""
        return ~echo_ends(self.geometry, self.soundings)

    def copy(self) -> Self:
        """An independent twin."""
        twin = type(self)(self.geometry)
        twin.soundings = list(self.soundings)
        return twin


def echo_ends(geometry: GridGeometry, soundings: list[Sounding]) -> Mask:
    """(rows, cols) the cells at the ends of the axes of all echoes."""
    mask = np.zeros(geometry.shape, np.bool_)
    for sounding in soundings:
        if sounding.echo is not None:
            end = sounding.transducer.compose(Pose(sounding.echo))
            cell = geometry.cell(end.x, end.y)
            if geometry.contains(*cell):
                mask[cell] = True
    return mask


def play(recording: Recording) -> tuple[GridGeometry, tuple[RingPing, ...]]:
    """The area of the log's map, and all pings that a map is made of, in their order, at the log's poses.

    Raises UsageError when it has no poses, or spans more than a map can hold.
    """
    tapes: list[EchoTape] = []

    def record(area: GridGeometry) -> EchoTape:
        tapes.append(EchoTape(area))
        return tapes[-1]

    offline.build(recording, record)
    (tape,) = tapes
    stamps = np.array([sounding.stamp_ns for sounding in tape.soundings], np.int64)
    speeds = speed_at(recording.poses, stamps)
    pings = (RingPing(each, float(speed)) for each, speed in zip(tape.soundings, speeds, strict=True))
    return tape.geometry, tuple(pings)


def speed_at(poses: list[tuple[int, Pose]], stamps_ns: NDArray[np.int64]) -> NDArray[np.float64]:
    """(n,) m/s, the robot's at each stamp; turns in place do not count."""
    times = np.array([stamp_ns - poses[0][0] for stamp_ns, _ in poses]) / SECOND_NS
    places = np.array([[pose.x, pose.y] for _, pose in poses])
    way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(places, axis=0).T))])
    now = (stamps_ns - poses[0][0]) / SECOND_NS
    before, after = np.maximum(now - _SLOPE_S, 0.0), np.minimum(now + _SLOPE_S, times[-1])
    gone = np.interp(after, times, way) - np.interp(before, times, way)
    result: NDArray[np.float64] = gone / np.maximum(after - before, 1e-9)
    return result
