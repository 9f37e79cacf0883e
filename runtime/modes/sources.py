"""From a word on the command line to a source of wishes."""

from math import radians
from pathlib import Path

from echogrid.runtime.config import DriveConfig
from echogrid.runtime.errors import UsageError
from echogrid.runtime.joystick_wishes import JoystickLayout, JoystickWishes
from echogrid.runtime.socket_wishes import SocketWishes, udp_socket, unix_socket
from echogrid.runtime.wishes import Wishes

_HERE = "127.0.0.1"


def opened(source: str, limits: DriveConfig) -> Wishes:
    """What that names. Raises UsageError. A joystick at full deflection wishes for the limits."""
    kind, _, place = source.partition(":")
    try:
        if kind == "joystick" and place:
            full = JoystickLayout(
                most_speed=limits.max_speed_mps, most_turn_rate=radians(limits.max_turn_dps)
            )
            return JoystickWishes(Path(place), full)
        if kind == "unix" and place:
            return SocketWishes(unix_socket(Path(place)))
        host, _, port = place.rpartition(":")
        if kind == "udp" and port.isdecimal():
            return SocketWishes(udp_socket(int(port), host or _HERE))
    except (OSError, OverflowError) as error:
        told = error.strerror if isinstance(error, OSError) else "no such port"
        raise UsageError([f"--guard {source}: {told}"]) from error
    forms = "unix:PATH, udp:PORT, udp:HOST:PORT or joystick:/dev/input/js0"
    raise UsageError([f"--guard {source}: not a source of wishes (try {forms})"])
