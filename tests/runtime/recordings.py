"""Recordings in the simple format, made by hand."""

from collections.abc import Iterable
from math import cos, pi, sin
from pathlib import Path

ROBOT = """\
[robot]
name = "hand-made"
wheel_radius_m = 0.05
track_m = 0.3

[map]
resolution_m = 0.1

[[sensor]]
name = "front"
x_m = 0.1
y_m = 0.0
yaw_deg = 0.0
half_angle_deg = 12.0
min_m = 0.05
max_m = 3.0

[[sensor]]
name = "left"
x_m = 0.0
y_m = 0.1
yaw_deg = 90.0
half_angle_deg = 12.0
min_m = 0.05
max_m = 3.0
"""
RANGES_HEADER = "stamp_s,sensor,range_m"
POSES_HEADER = "stamp_s,x_m,y_m,yaw_rad"
WHEELS_HEADER = "stamp_s,left_rad,right_rad"


def pose_rows(seconds: float = 10.0) -> list[str]:
    """A slow circle, ten poses a second."""
    turns = [0.05 * step for step in range(int(seconds * 10) + 1)]
    return [
        f"{0.1 * step:.9f},{sin(turn):.6f},{1 - cos(turn):.6f},{turn % pi:.6f}"
        for step, turn in enumerate(turns)
    ]


def range_rows(seconds: float = 10.0) -> list[str]:
    """Twenty pings a second, of every outcome."""
    special = {5: "inf", 11: "-inf", 17: "nan"}
    told = [special.get(step % 23, f"{0.8 + 0.1 * (step % 7):.3f}") for step in range(int(seconds * 20))]
    return [f"{0.05 * step:.9f},{('front', 'left')[step % 2]},{text}" for step, text in enumerate(told)]


def write(
    folder: Path,
    ranges: Iterable[str] | bytes | None = None,
    poses: Iterable[str] | bytes | None = None,
    robot: str = ROBOT,
    wheels: Iterable[str] | None = None,
) -> Path:
    """A recording; rows follow the header, bytes are the whole file."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "robot.toml").write_text(robot)
    _table(folder / "ranges.csv", RANGES_HEADER, range_rows() if ranges is None else ranges)
    if wheels is None:
        _table(folder / "poses.csv", POSES_HEADER, pose_rows() if poses is None else poses)
    else:
        _table(folder / "wheels.csv", WHEELS_HEADER, wheels)
    return folder


def _table(path: Path, header: str, rows: Iterable[str] | bytes) -> None:
    path.write_bytes(rows if isinstance(rows, bytes) else "\n".join([header, *rows, ""]).encode())
