"""What every driver of a ranger on I2C that pings when told to tells of itself."""

from collections.abc import Mapping
from typing import ClassVar

from echogrid.drivers.bus import I2cResult, I2cTransfer
from echogrid.drivers.commanded import CommandedRanger
from echogrid.drivers.device import Line


class I2cRanger(CommandedRanger[I2cTransfer]):
    """One ranger, known by its address; it adds its `Settings` and its make."""

    bus: ClassVar[str] = "i2c"
    line: ClassVar[type[Line[I2cResult, I2cTransfer]]] = Line
    identity: ClassVar[str] = "address"
    port_options: ClassVar[Mapping[str, object]] = {}
