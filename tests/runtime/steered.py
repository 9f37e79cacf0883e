"""The emulated robot on a driven and a steered wheel, whose encoder is absolute."""

from pathlib import Path

from echogrid.runtime import robot_file
from echogrid.runtime.config import Config
from echogrid.runtime.emulated import DEFAULT_ROBOT

WHEELBASE = 0.32
_WHEEL = '\n[[wheel]]\nname = "{0}"\ndriver = "{1}"\nbus = "wheel_bus"\nnode = {2}\n'


def text(drive: str, more: str = "") -> str:
    """Its robot.toml, with more keys of its steering."""
    before, _, rest = DEFAULT_ROBOT.read_text().partition("[[wheel]]")
    sensors = rest[rest.index("[[sensor]]") :]
    before = before.replace("track_m = 0.32", f'drive = "{drive}"\nwheelbase_m = {WHEELBASE}')
    before = before.replace('interface = "slcan"', 'interface = "virtual"').replace("bit_rate = 500000\n", "")
    wheels = _WHEEL.format("drive", "moteus", 1) + _WHEEL.format("steering", "moteus", 2)
    return f"{before}{wheels}{more}\n{sensors}"


def config(folder: Path, drive: str, more: str = "") -> Config:
    """That file in a folder, read."""
    path = folder / "robot.toml"
    path.write_text(text(drive, more))
    return robot_file.load(path)
