"""The measuring half of an emulated ranger: it pings, listens, and has its ways to fail."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from random import Random

from echogrid.emulation.devices.device import LOOKED_UP
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.faults import Faults, Verb
from echogrid.emulation.scene import Echo

SLOWNESS = 5
"""How many times as long a slow ranger takes."""
_WRONG = 1.5
"""A wrong ranger's distances are so many times the true ones."""

RANGING_VERBS: Mapping[str, Verb] = {"stuck": LOOKED_UP, "wrong": LOOKED_UP, "slow": LOOKED_UP}
"""The faults that a device gets with its sonar."""


class Sonar:
    """A ranger's transducer. Its device says when it fires, and asks what was heard when it has listened."""

    def __init__(self, surroundings: Surroundings, faults: Faults, random: Random) -> None:
        self.random = random
        """Of all chance in the device."""
        self._surroundings = surroundings
        self._faults = faults
        self._fired_ns = 0
        self._silent = False
        self._last: tuple[Echo, ...] = ()

    @property
    def speed_of_sound(self) -> float:
        """m/s, the true one."""
        return self._surroundings.speed_of_sound

    @property
    def slowness(self) -> int:
        """By how much it takes longer than it should."""
        return SLOWNESS if "slow" in self._faults else 1

    def fire(self, now_ns: int, silent: bool = False) -> None:
        """Begin to listen, with a ping unless it is a silent one."""
        self._fired_ns = now_ns
        self._silent = silent
        if not silent:
            self._surroundings.ping(now_ns)

    def echoes(self) -> tuple[Echo, ...]:
        """What was heard since it fired, nearest first; to be asked when it has done listening."""
        if "stuck" not in self._faults:
            hear = self._surroundings.ambient if self._silent else self._surroundings.scene
            self._last = hear(self._fired_ns)
        if "wrong" in self._faults:
            return tuple(replace(echo, distance=_WRONG * echo.distance) for echo in self._last)
        return self._last

    def first(self, reach: float, nearest: float = 0.0) -> float | None:
        """Distance (m) of the first echo heard at full gain, `nearest` to `reach`; None: there is none."""
        return first_heard(self.echoes(), reach, nearest)


def first_heard(echoes: Sequence[Echo], reach: float, nearest: float = 0.0) -> float | None:
    """Distance (m) of the first of them that is heard at full gain from `nearest` to `reach`."""
    heard = (echo.distance for echo in echoes if echo.margin >= 0)
    return next((distance for distance in heard if nearest <= distance <= reach), None)
