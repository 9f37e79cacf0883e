"""What an emulated ranger has around it."""

from collections.abc import Callable
from dataclasses import dataclass

from echogrid.emulation.scene import Echo, Scene


def _silence(start_ns: int) -> tuple[Echo, ...]:
    """Nobody else pings."""
    del start_ns
    return ()


def _nobody_hears(fire_ns: int) -> None:
    """Nobody else listens."""
    del fire_ns


@dataclass(frozen=True, slots=True)
class Surroundings:
    """The echoes that a ranger hears, and the air they come through.

    A ranger calls `ping` at the moment when it fires, and asks for the `scene` of that moment when it has
    done listening: what others fired meanwhile is in it, too.
    """

    scene: Scene
    speed_of_sound: float
    """m/s, the true one."""
    ambient: Scene = _silence
    """Start of listening (ns) without an own ping -> what it hears of others, as if it had fired then."""
    ping: Callable[[int], None] = _nobody_hears
    """Tell everybody around that it fires at a time (ns)."""
