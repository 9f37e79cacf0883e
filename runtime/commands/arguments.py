"""What several commands take."""

import argparse
import os
import re
import tomllib
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from echogrid.runtime.recording import Recording

    Commands = argparse._SubParsersAction[argparse.ArgumentParser]

_UNITS_S = {"ms": 0.001, "s": 1.0, "": 1.0, "min": 60.0, "h": 3600.0}


def duration(text: str) -> float:
    """Seconds, from 60s, 1.5min, 2h, 500ms or a plain number of seconds."""
    match = re.fullmatch(r"([0-9.]+)\s*(ms|s|min|h|)", text.strip())
    try:
        seconds = float(match[1]) * _UNITS_S[match[2]] if match else 0.0
    except ValueError:
        seconds = 0.0
    if not (isfinite(seconds) and seconds > 0.0):
        raise argparse.ArgumentTypeError(f"{text!r} is no duration (try 60s, 1.5min, 500ms)")
    return seconds


def length(text: str) -> float:
    """Metres, above 0."""
    try:
        metres = float(text)
    except ValueError:
        metres = 0.0
    if not (isfinite(metres) and metres > 0.0):
        raise argparse.ArgumentTypeError(f"{text!r} is no length in metres")
    return metres


def finite(text: str) -> float:
    """A number."""
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not isfinite(value):
        raise argparse.ArgumentTypeError(f"{text!r} is no number")
    return value


def count(text: str) -> int:
    """A whole number from 1 on."""
    try:
        number = int(text)
    except ValueError:
        number = 0
    if number < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is no count (a whole number from 1 on)")
    return number


def seed(text: str) -> int:
    """A whole number from 0 on."""
    try:
        number = int(text)
    except ValueError:
        number = -1
    if number < 0:
        raise argparse.ArgumentTypeError(f"{text!r} is no seed (a whole number from 0 on)")
    return number


def robot_directory() -> Path:
    """Where this user's emulated robot lives by default."""
    runtime = os.environ.get("XDG_RUNTIME_DIR")
    return Path(runtime) / "echogrid" if runtime else Path(f"/tmp/echogrid-{os.getuid()}")


def add_settings(parser: argparse.ArgumentParser, told: str) -> None:
    """--set KEY=VALUE, as often as wanted; `told` is its help."""
    parser.add_argument(
        "--set",
        dest="settings",
        type=_setting,
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help=told,
    )


def _setting(text: str) -> tuple[str, Any]:
    """A key of a driver and its value, as they would stand in robot.toml; a text needs no quotes."""
    key, equals, value = text.partition("=")
    if not key or not equals:
        raise argparse.ArgumentTypeError(f"{text!r} is no setting (try address=0x71)")
    try:
        return key.strip(), tomllib.loads(f"value = {value}")["value"]
    except tomllib.TOMLDecodeError:
        return key.strip(), value.strip()


THEORIES = ("bayes", "dempster-shafer", "himm", "counting", "calibrated")
"""As the configuration has them."""


def add_log(parser: argparse.ArgumentParser) -> None:
    """LOG, and --format."""
    parser.add_argument("log", type=Path, metavar="LOG", help="the folder of the recording")
    parser.add_argument("--format", choices=("simple", "robond"), default="simple")


def recorded(arguments: argparse.Namespace) -> "Recording":
    """The recording that is meant. Raises UsageError."""
    from echogrid.runtime import recording, robond

    read = robond.read if arguments.format == "robond" else recording.read_simple
    return read(arguments.log)


def add_theory(parser: argparse.ArgumentParser) -> None:
    """--theory, of the long-term map."""
    parser.add_argument(
        "--theory", choices=THEORIES, help="how evidence is fused into a map (default: as configured)"
    )


def add_directory(parser: argparse.ArgumentParser) -> None:
    """--dir, the emulated robot's."""
    parser.add_argument(
        "--dir",
        type=Path,
        default=robot_directory(),
        help="the folder of the emulated robot's ports (default: %(default)s)",
    )


def add_seed(parser: argparse.ArgumentParser) -> None:
    """--seed, of all chance."""
    parser.add_argument("--seed", type=seed, default=1, help="of the emulated noise (default: 1)")
