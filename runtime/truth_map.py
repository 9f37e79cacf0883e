"""What is true of a place, from the file of a map: to judge other maps by."""

import zlib
from dataclasses import dataclass
from math import ceil, floor, isclose
from pathlib import Path
from zipfile import BadZipFile, ZipFile

import numpy as np

from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.metrics import Mask
from echogrid.runtime import map_reading
from echogrid.runtime.errors import UsageError

_MOST_TURNED = 1e-9
"""rad: what a map's yaw may be."""
_FARTHEST_M = 1e9
"""Beyond that an origin is nonsense."""
_LARGEST = 1 << 28
"""Bytes of an array: more than any map of ours has."""
_HALF = 0.5
_DAMAGES = (
    ValueError,
    KeyError,
    TypeError,
    EOFError,
    OSError,
    RuntimeError,
    MemoryError,
    BadZipFile,
    zlib.error,
)
"""What reading an archive raises that is none, or was changed on its way."""


@dataclass(frozen=True, slots=True)
class TruthMap:
    """Which cells are walls, and which are free; the others are not judged. Masks are (rows, cols)."""

    geometry: GridGeometry
    walls: Mask
    free: Mask

    def lattice(self, area: GridGeometry) -> GridGeometry:
        """The cells of this map, continued over another area. Raises UsageError if its cells are larger or
        smaller."""
        mine, size = self.geometry, self.geometry.resolution
        if not isclose(size, area.resolution, rel_tol=1e-6):
            told = f"the truth has cells of {size:g} m, the log's map of {area.resolution:g} m"
            raise UsageError([f"{told}: give [map] `resolution_m` of the log's robot.toml the truth's"])
        first_row, first_col = floor((area.y - mine.y) / size), floor((area.x - mine.x) / size)
        last_row = ceil((area.y - mine.y) / size + area.rows)
        last_col = ceil((area.x - mine.x) / size + area.cols)
        corner = mine.x + first_col * size, mine.y + first_row * size
        return GridGeometry(size, *corner, last_row - first_row, last_col - first_col)

    def on(self, lattice: GridGeometry) -> tuple[Mask, Mask]:
        """Walls and free cells on a grid whose cells continue this map's; what lies beyond it is neither."""
        size = self.geometry.resolution
        row = round((self.geometry.y - lattice.y) / size)
        col = round((self.geometry.x - lattice.x) / size)
        return _laid(self.walls, row, col, lattice), _laid(self.free, row, col, lattice)


def read(path: Path) -> TruthMap:
    """The map in a map.yaml (of nav2's map_server, with its PGM or PNG) or a map.npz of our own.

    Raises UsageError when it is neither, or turned against its frame.
    """
    if not path.is_file():
        raise UsageError([f"{path}: no such file (the truth is a map.yaml or a map.npz)"])
    if path.suffix == ".npz":
        return _from_arrays(path)
    if path.suffix in (".yaml", ".yml"):
        return _from_yaml(path)
    raise UsageError([f"{path}: is no map: the truth is a map.yaml or a map.npz"])


def _from_arrays(path: Path) -> TruthMap:
    try:
        with ZipFile(path) as archive:
            if max((each.file_size for each in archive.infolist()), default=0) > _LARGEST:
                raise ValueError("it holds more than any map")
        with np.load(path, allow_pickle=False) as arrays:
            occupancy, unknown = arrays["occupancy"], arrays["unknown"]
            origin, resolution = [float(each) for each in arrays["origin"]], float(arrays["resolution"])
        if occupancy.dtype.kind != "f" or unknown.dtype != np.bool_ or occupancy.shape != unknown.shape:
            raise ValueError("`occupancy` and `unknown` are not numbers and truth values of one shape")
        geometry = _geometry(path, resolution, origin, occupancy.shape)
        return TruthMap(geometry, (occupancy > _HALF) & ~unknown, (occupancy < _HALF) & ~unknown)
    except _DAMAGES as error:
        raise UsageError([f"{path}: is no map.npz of ours: {error}"]) from error


def _from_yaml(path: Path) -> TruthMap:
    read_map = map_reading.read(path)
    x, y, yaw = read_map.origin.x, read_map.origin.y, read_map.origin.yaw
    geometry = _geometry(path, read_map.resolution, [x, y, yaw], read_map.occupied.shape)
    return TruthMap(geometry, read_map.occupied, read_map.free)


def _geometry(path: Path, resolution: float, origin: list[float], shape: tuple[int, ...]) -> GridGeometry:
    """Raises UsageError or ValueError."""
    if len(origin) != 3 or not all(abs(each) <= _FARTHEST_M for each in origin):
        raise ValueError("origin must be x, y (m) and yaw (rad)")
    x, y, yaw = origin
    if abs(yaw) > _MOST_TURNED:
        raise UsageError([f"{path}: its origin is turned by {yaw:g} rad: the truth must lie as the log does"])
    rows, cols = shape
    return GridGeometry(resolution, x, y, rows, cols)


def _laid(mask: Mask, row: int, col: int, lattice: GridGeometry) -> Mask:
    """The mask with its first cell at that row and column of a grid."""
    result = np.zeros(lattice.shape, np.bool_)
    rows, cols = mask.shape
    first_row, first_col = max(row, 0), max(col, 0)
    last_row, last_col = min(row + rows, lattice.rows), min(col + cols, lattice.cols)
    if first_row < last_row and first_col < last_col:
        part = mask[first_row - row : last_row - row, first_col - col : last_col - col]
        result[first_row:last_row, first_col:last_col] = part
    return result
