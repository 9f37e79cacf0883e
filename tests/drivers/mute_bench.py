"""A ranger on I2C played by hand which need not acknowledge while it ranges."""

from errno import ENXIO

from echogrid.drivers.bus import I2cResult, I2cTransfer
from echogrid.drivers.role import RangerRole, Slot

from .i2c_bench import MS, SPEED, TRANSFER_NS, Bench, Ranger

SLOT = Slot(300 * MS, 30 * MS)


def role(nearest: float, farthest: float, slot: Slot | None = SLOT) -> RangerRole:
    return RangerRole("left", nearest, farthest, slot, SPEED)


class MuteBench(Bench):
    """Answers what `registers` says, whatever is asked for."""

    def __init__(self, device: Ranger, registers: bytes, fires: bytes) -> None:
        super().__init__(device, registers, fires)
        self.mute_ns = 0
        """For so long after it was fired it does not acknowledge."""
        self.transfers: list[I2cTransfer] = []

    def result(self, transfer: I2cTransfer) -> I2cResult:
        self.transfers.append(transfer)
        start_ns = self.now_ns
        if self.fired_ns and start_ns < self.fired_ns[-1] + self.mute_ns:
            self.now_ns += TRANSFER_NS
            return I2cResult(transfer, start_ns, self.now_ns, errno=ENXIO)
        return super().result(transfer)
