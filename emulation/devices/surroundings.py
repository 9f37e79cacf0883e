"""What an emulated ranger has around it."""

from dataclasses import dataclass

from echogrid.emulation.scene import Scene


@dataclass(frozen=True, slots=True)
class Surroundings:
    """The echoes that it hears, and the air they come through."""

    scene: Scene
    speed_of_sound: float
    """m/s, the true one."""
