"""Map files: nav2 map_server's YAML and PGM, a picture, arrays, and the path."""

from collections.abc import Sequence
from io import BytesIO
from math import cos, sin
from pathlib import Path
from typing import Any

import numpy as np

from echogrid.mapping.long_term_map import MapImage
from echogrid.mapping.pose import Pose
from echogrid.runtime import png
from echogrid.runtime.map_picture import picture

OCCUPIED_THRESHOLD = 0.65
FREE_THRESHOLD = 0.196
"""map_server's default of 0.25 would read the pixel of unknown, 205, as free."""

Trajectory = Sequence[tuple[int, Pose]]
"""Stamps (ns) and poses in the map frame."""


def write(folder: Path, image: MapImage, trajectory: Trajectory) -> None:
    """Write map.yaml, map.pgm, map.png, map.npz and trajectory.tum; each appears whole or not at all.

    Raises OSError.
    """
    folder.mkdir(parents=True, exist_ok=True)
    replace(folder / "map.pgm", _pgm(image))
    replace(folder / "map.yaml", _yaml(image).encode())
    replace(folder / "map.png", png.encode(picture(image, [pose for _, pose in trajectory])))
    replace(folder / "map.npz", _npz(image))
    replace(folder / "trajectory.tum", "".join(map(_tum, trajectory)).encode())


def replace(path: Path, data: bytes) -> None:
    """Put a file in place in one step, whatever was there. Raises OSError, which names it."""
    part = path.with_name(f".{path.name}.part")
    try:
        part.write_bytes(data)
        part.replace(path)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise OSError(error.errno, error.strerror, str(path)) from error


def _pgm(image: MapImage) -> bytes:
    pixels = np.full(image.geometry.shape, 205, np.uint8)
    pixels[image.occupancy < FREE_THRESHOLD] = 254
    pixels[image.occupancy > OCCUPIED_THRESHOLD] = 0
    pixels[image.unknown] = 205
    rows, cols = pixels.shape
    return f"P5\n{cols} {rows}\n255\n".encode() + pixels[::-1].tobytes()


def _yaml(image: MapImage) -> str:
    geometry = image.geometry
    return (
        "image: map.pgm\nmode: trinary\n"
        f"resolution: {geometry.resolution}\norigin: [{geometry.x!r}, {geometry.y!r}, 0.0]\nnegate: 0\n"
        f"occupied_thresh: {OCCUPIED_THRESHOLD}\nfree_thresh: {FREE_THRESHOLD}\n"
    )


def _npz(image: MapImage) -> bytes:
    """`occupancy` and `unknown` (rows, cols) with row 0 south, `resolution` m, `origin` x, y, yaw of the
    lower-left corner, and the theory's own layers. The same map gives the same bytes."""
    buffer = BytesIO()
    arrays: dict[str, Any] = {
        "occupancy": image.occupancy,
        "unknown": image.unknown,
        "resolution": np.float64(image.geometry.resolution),
        "origin": np.array([image.geometry.x, image.geometry.y, 0.0]),
        **image.layers,
    }
    np.savez_compressed(buffer, **arrays)
    return buffer.getvalue()


def _tum(entry: tuple[int, Pose]) -> str:
    stamp_ns, pose = entry
    turn = f"0 0 {sin(pose.yaw / 2.0):.9f} {cos(pose.yaw / 2.0):.9f}"
    return f"{seconds(stamp_ns)} {pose.x:.6f} {pose.y:.6f} 0 {turn}\n"


def seconds(stamp_ns: int) -> str:
    """A stamp in seconds, with all its digits."""
    whole, part = divmod(abs(stamp_ns), 1_000_000_000)
    return f"{'-' if stamp_ns < 0 else ''}{whole}.{part:09d}"
