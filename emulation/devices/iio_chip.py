"""Rangers on I2C which the kernel reads: it commands a ping, waits, and fetches centimetres."""

from collections.abc import Mapping
from dataclasses import dataclass
from errno import EINVAL, EIO, ENXIO, ETIMEDOUT
from random import Random

from echogrid.emulation.devices.device import LOOKED_UP
from echogrid.emulation.devices.iio_device import Files, IioDevice, Reply
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.faults import Verb

_SCALE = "0.010000"
_COMMAND_NS = 300_000
"""Three bytes at 100 kHz."""
_STORM = 0.7
"""Of the reads in a storm so many fail."""


@dataclass(frozen=True, slots=True)
class _Chip:
    """A chip of this kind, and what the kernel's driver makes of it."""

    ranging_ns: int
    gives_up_ns: int
    """The kernel waits no longer."""
    errno: int
    """What it says then."""
    reach: float
    """m."""
    speed_of_sound: float
    """m/s, with which it makes centimetres of times at any temperature."""
    least_cm: int
    no_echo_cm: int
    signed: bool
    """To the kernel, half of what two bytes may say is below zero, and so an error."""


CHIPS: Mapping[str, _Chip] = {
    "srf08": _Chip(36_000_000, 57_000_000, EIO, 6.0, 343.0, 3, 0, signed=False),
    "maxbotix-mb1232": _Chip(75_000_000, 100_000_000, ETIMEDOUT, 7.6, 344.8, 20, 765, signed=True),
}
"""By the name of the kernel's driver; the second one with its status pin as an interrupt."""


class IioChipRanger(IioDevice):
    """Its gain and range are those that the kernel sets at first, and outlast its power."""

    def __init__(self, name: str, device: str, surroundings: Surroundings, random: Random, kind: str) -> None:
        super().__init__(name, device, surroundings, random, Files(kind, _SCALE))
        self._chip = CHIPS[kind]

    def _verbs(self) -> Mapping[str, Verb]:
        return {**super()._verbs(), "nack_storm": LOOKED_UP}

    def _range(self, now_ns: int) -> None:
        fired_ns = now_ns + _COMMAND_NS
        if not self.has_contact(now_ns):
            self._end(Reply(errno=ENXIO), fired_ns)
        elif "nack_storm" in self.faults and self.sonar.random.random() < _STORM:
            self._end(Reply(errno=EIO), fired_ns)
        else:
            self._after(fired_ns, self._fire)

    def _fire(self, now_ns: int) -> None:
        self.sonar.fire(now_ns)
        takes_ns = self._chip.ranging_ns * self.sonar.slowness + self._delay_ns()
        if takes_ns > self._chip.gives_up_ns:
            self._end(Reply(errno=self._chip.errno), now_ns + self._chip.gives_up_ns)
        else:
            self._after(now_ns + takes_ns, self._hear)

    def _hear(self, now_ns: int) -> None:
        value = self.sonar.random.randrange(1 << 16) if "garbage" in self.faults else self._centimetres()
        below_zero = self._chip.signed and value >= 1 << 15
        self._end(Reply(errno=EINVAL) if below_zero else Reply(b"%d\n" % value), now_ns + _COMMAND_NS)

    def _centimetres(self) -> int:
        distance = self.sonar.first(self._chip.reach)
        if distance is None:
            return self._chip.no_echo_cm
        own = 100 * distance * self._chip.speed_of_sound / self.sonar.speed_of_sound
        return max(round(own), self._chip.least_cm)

    def _break_off(self) -> None:
        """It does not acknowledge when the kernel comes for the answer."""
        self._end(Reply(errno=ENXIO), self._due_ns)
