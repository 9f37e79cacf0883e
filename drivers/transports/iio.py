"""IIO ports: reads of the kernel's sensors out, their results back."""

from echogrid.drivers.bus import IioRead, IioResult
from echogrid.drivers.transports.transfers import Adapter, TransferPort


class IioPort(TransferPort[IioRead, IioResult]):
    """The sensors of one kernel, read one after the other."""

    def __init__(self, adapter: Adapter[IioRead]) -> None:
        super().__init__(adapter, IioResult)
