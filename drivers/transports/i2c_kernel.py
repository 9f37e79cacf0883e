"""The kernel's I2C adapters, /dev/i2c-N, by smbus2."""

from errno import EBADF, ENODEV, ENOTTY, EOPNOTSUPP
from fcntl import ioctl
from math import ceil
from typing import TYPE_CHECKING, cast

from echogrid.drivers.bus import I2cTransfer
from echogrid.drivers.errors import PortError
from echogrid.drivers.transports.mend import cannot_open

if TYPE_CHECKING:
    import smbus2

I2C_TIMEOUT = 0x0702
"""An ioctl; its unit is 10 ms."""
GONE = {EBADF, ENODEV}
UNABLE = {ENOTTY, EOPNOTSUPP}


class KernelAdapter:
    """One /dev/i2c-N."""

    def __init__(self, address: str, timeout_s: float) -> None:
        self._address = address
        self._timeout_s = timeout_s
        self._bus: smbus2.SMBus | None = None

    def open(self) -> None:
        """Make ready. Raises PortError, which names the port and the mend."""
        import smbus2

        self.close()
        bus = smbus2.SMBus()
        try:
            bus.open(self._address)
            ioctl(cast(int, bus.fd), I2C_TIMEOUT, ceil(self._timeout_s * 100))
        except OSError as error:
            bus.close()
            raise cannot_open("I2C", self._address, "i2c", error) from error
        self._bus = bus

    def close(self) -> None:
        """Let go. May be called twice."""
        if self._bus is not None:
            self._bus.close()
            self._bus = None

    def transfer(self, transfer: I2cTransfer) -> bytes:
        """The bytes read. Raises PortError when the adapter is lost, OSError when the transfer failed."""
        from smbus2 import i2c_msg

        if self._bus is None:
            raise PortError(f"{self._address}: not open")
        messages = [
            i2c_msg.write(message.address, message.write)
            if message.write
            else i2c_msg.read(message.address, message.read)
            for message in transfer.messages
        ]
        try:
            self._bus.i2c_rdwr(*messages)
        except OSError as error:
            if error.errno in GONE:
                raise PortError(f"{self._address}: I2C adapter lost, was it unplugged? ({error})") from error
            if error.errno in UNABLE:
                raise PortError(
                    f"{self._address}: not an adapter for plain I2C transfers ({error})"
                ) from error
            raise
        return b"".join(
            bytes(sent) for sent, message in zip(messages, transfer.messages, strict=True) if message.read
        )
