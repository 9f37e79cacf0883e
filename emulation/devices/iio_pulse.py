"""Rangers which tell the distance by the length of a pulse, timed by the kernel: SRF04, HC-SR04, PING)))."""

from collections.abc import Mapping
from dataclasses import dataclass
from errno import EIO, ETIMEDOUT
from random import Random

from echogrid.emulation.devices.iio_device import Files, IioDevice, Reply
from echogrid.emulation.devices.surroundings import Surroundings

_SCALE = "0.001000"
_RISES_WITHIN_NS = 20_000_000
_FALLS_WITHIN_NS = 50_000_000
"""The kernel waits so long for a pulse to begin, and for it to end."""
_NOISE_NS = 70_000_000
"""Pulses of a noisy line are up to so long."""


@dataclass(frozen=True, slots=True)
class _Pulses:
    """A ranger of this kind, and what the kernel's driver makes of it."""

    hold_off_ns: int
    """From the trigger to the pulse, at whose beginning the sound leaves."""
    shortest_ns: int
    no_echo_ns: int
    """How long it is when nothing comes back."""
    reach: float
    """m."""
    limit_ns: int
    """Longer pulses are an error to the kernel."""
    multiply: int
    divide: int
    """Its way from ns to mm."""


PULSES: Mapping[str, _Pulses] = {
    "srf04": _Pulses(500_000, 115_000, 38_000_000, 4.0, 40_438_871, 106, 617_176),
    "ping": _Pulses(750_000, 115_000, 18_500_000, 3.0, 18_500_000, 232, 1_350_800),
}
"""By the name of the kernel's driver; the first one's ranger is an HC-SR04."""


class IioPulseRanger(IioDevice):
    """A trigger while the pulse before lasts does nothing. Without power its line is low."""

    def __init__(
        self, name: str, device: str, surroundings: Surroundings, random: Random, kind: str, no_echo_ns: int
    ) -> None:
        """`no_echo_ns` is how long the pulse is when nothing comes back; 0: as usual."""
        super().__init__(name, device, surroundings, random, Files(kind, _SCALE))
        self._pulses = PULSES[kind]
        self._no_echo_ns = no_echo_ns or self._pulses.no_echo_ns
        self._listens_ns = round(2e9 * self._pulses.reach / surroundings.speed_of_sound)
        self._gives_up_ns = 0
        self._low_ns = 0
        """When the last pulse ends."""

    def _range(self, now_ns: int) -> None:
        self._gives_up_ns = now_ns + _RISES_WITHIN_NS
        rises_ns = now_ns + self._pulses.hold_off_ns * self.sonar.slowness + self._delay_ns()
        if self.has_contact(now_ns) and now_ns >= self._low_ns and rises_ns < self._gives_up_ns:
            self._after(rises_ns, self._rise)
        else:
            self._end(Reply(errno=ETIMEDOUT), self._gives_up_ns)

    def _rise(self, now_ns: int) -> None:
        self.sonar.fire(now_ns)
        self._gives_up_ns = now_ns + _FALLS_WITHIN_NS
        self._after(now_ns + self._listens_ns, self._hear)

    def _hear(self, now_ns: int) -> None:
        """The read ends when the pulse does; never before what may come back has been listened for."""
        rose_ns = now_ns - self._listens_ns
        pulse_ns = self._pulse_ns()
        self._low_ns = rose_ns + pulse_ns
        if self._low_ns > self._gives_up_ns:
            self._end(Reply(errno=ETIMEDOUT), self._gives_up_ns)
        else:
            self._end(self._measured(pulse_ns), max(self._low_ns, now_ns))

    def _pulse_ns(self) -> int:
        if "garbage" in self.faults:
            return self.sonar.random.randrange(_NOISE_NS)
        listened = self.sonar.speed_of_sound * self._no_echo_ns / 2e9
        distance = self.sonar.first(min(self._pulses.reach, listened))
        if distance is None:
            return self._no_echo_ns
        return max(round(2e9 * distance / self.sonar.speed_of_sound), self._pulses.shortest_ns)

    def _measured(self, pulse_ns: int) -> Reply:
        if pulse_ns > self._pulses.limit_ns:
            return Reply(errno=EIO)
        return Reply(b"%d\n" % (pulse_ns * self._pulses.multiply // self._pulses.divide))

    def _power_down(self) -> None:
        self._low_ns = 0
        super()._power_down()

    def _break_off(self) -> None:
        """No edge comes any more."""
        self._end(Reply(errno=ETIMEDOUT), self._gives_up_ns)
