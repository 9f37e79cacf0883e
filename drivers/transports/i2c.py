"""I2C ports: transfers out, their results back."""

from echogrid.drivers.bus import I2cResult, I2cTransfer
from echogrid.drivers.transports.transfers import Adapter, TransferPort


class I2cPort(TransferPort[I2cTransfer, I2cResult]):
    """The master of an I2C bus."""

    def __init__(self, adapter: Adapter[I2cTransfer]) -> None:
        super().__init__(adapter, I2cResult)
