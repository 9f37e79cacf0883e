"""A port that knows how its bus is, beside whether it is there."""

from abc import ABC, abstractmethod

from echogrid.drivers.device import Health, State

EXPLAINED = frozenset({State.WELL, State.SETTING_UP, State.SILENT, State.STALLED, State.MISSING})
"""States of a device of which its bus's trouble says more; any other is its own trouble."""


class Supervised(ABC):
    """May be asked by any thread."""

    @abstractmethod
    def health(self, now_ns: int) -> Health:
        """How the bus is. WELL may have a message too: what is set up badly, and the line that mends it."""


def beside(device: Health, bus: Health) -> Health:
    """The health of a device on that bus: the bus's trouble comes first where it explains the device's.

    A bus may be silent because nobody has been asked: that is no trouble of a device which is well.
    """
    counts = {**device.counts, **bus.counts}
    quiet = bus.state is State.SILENT and device.state is State.WELL
    if bus.state is not State.WELL and device.state in EXPLAINED and not quiet:
        return Health(bus.state, bus.message, counts)
    told = device.message if quiet else "; ".join(filter(None, (device.message, bus.message)))
    return Health(device.state, told, counts)
