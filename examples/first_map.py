"""A recording made by hand, and its map: a robot drives along a wall to its left and hears it.

Run it with: python examples/first_map.py FOLDER
"""

import sys
from pathlib import Path

from echogrid.runtime import map_files, offline, recording

ROBOT = """
[robot]
name = "example"

[[sensor]]
name = "left"
x_m = 0.0
y_m = 0.1
yaw_deg = 90.0
half_angle_deg = 10.0
min_m = 0.04
max_m = 4.0
"""


def main(folder: Path) -> None:
    """Write the recording into the folder, and its map beside it."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "robot.toml").write_text(ROBOT)
    times = [0.1 * step for step in range(100)]
    poses = [f"{t:.1f},{0.3 * t:.3f},0.0,0.0" for t in times]
    ranges = [f"{t:.1f},left,1.15" for t in times]
    (folder / "poses.csv").write_text("\n".join(["stamp_s,x_m,y_m,yaw_rad", *poses, ""]))
    (folder / "ranges.csv").write_text("\n".join(["stamp_s,sensor,range_m", *ranges, ""]))
    told = recording.read_simple(folder)
    made = offline.build(told)
    map_files.write(folder / "map", made.image, told.poses)
    print(f"{made.ledger.fused} readings fused; look at {folder / 'map' / 'map.png'}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
