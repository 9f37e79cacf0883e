"""An emulated ranger behind a driver of the kernel's, by that driver's name."""

from dataclasses import dataclass
from random import Random

from echogrid.emulation.devices.iio_chip import CHIPS, IioChipRanger
from echogrid.emulation.devices.iio_device import IioDevice
from echogrid.emulation.devices.iio_pulse import PULSES, IioPulseRanger
from echogrid.emulation.devices.surroundings import Surroundings

_USUAL = "srf04"


@dataclass(frozen=True, slots=True)
class IioOptions:
    """What differs between them."""

    device: str = _USUAL
    """The name by which it is read."""
    kernel_driver: str = ""
    """By default what `device` says, if that is one, or srf04."""
    no_echo_ns: int = 0
    """How long the pulse of an srf04 or ping is when nothing comes back: clones differ; 0: as usual."""

    def __post_init__(self) -> None:
        known = (*PULSES, *CHIPS)
        if self.kernel_driver and self.kernel_driver not in known:
            raise ValueError(
                f"kernel_driver {self.kernel_driver!r} is none of those emulated: {', '.join(known)}"
            )

    @property
    def kind(self) -> str:
        """The kernel's driver."""
        known = self.device in PULSES or self.device in CHIPS
        return self.kernel_driver or (self.device if known else _USUAL)


def iio_ranger(name: str, surroundings: Surroundings, random: Random, options: IioOptions) -> IioDevice:
    """A ranger, without power."""
    device, kind = options.device, options.kind
    if kind in PULSES:
        return IioPulseRanger(name, device, surroundings, random, kind, options.no_echo_ns)
    return IioChipRanger(name, device, surroundings, random, kind)
