"""How rangers are given another address: the messages of each make, and when they count."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from echogrid.drivers import devantech, i2cxl, srf01, srf02_serial, urm07, urm_i2c, urm_modbus
from echogrid.drivers.bus import I2cMessage, I2cTransfer, Result, SerialTransfer
from echogrid.drivers.course import Course

Transfers = Callable[[int, int], Sequence[Any]]
"""Present and new address -> transfers, to be sent in this order with nothing in between.

Raises ValueError for an address that can't be."""


@dataclass(frozen=True, slots=True)
class Readdressing:
    """One make's way."""

    transfers: Transfers
    after_power_cycle: bool = False
    """Whether the new address counts only when the device was without power."""


def change(readdressing: Readdressing, old: int, new: int) -> Course[Any, str]:
    """Send the messages; why it failed, or nothing if it did not."""
    for transfer in readdressing.transfers(old, new):
        result: Result[Any] = yield transfer
        if result.errno:
            return (
                f"it did not take the message (errno {result.errno}): nothing may have changed, scan the bus"
            )
    return ""


def _devantech(old: int, new: int) -> list[I2cTransfer]:
    return [I2cTransfer((I2cMessage(old, message),)) for message in devantech.address_change(new)]


def _i2cxl(old: int, new: int) -> list[I2cTransfer]:
    return [I2cTransfer((I2cMessage(old, i2cxl.address_change(new)),))]


def _urm(old: int, new: int) -> list[I2cTransfer]:
    return [I2cTransfer((I2cMessage(old, urm_i2c.address_change(new)),))]


def _urm_modbus(old: int, new: int) -> list[SerialTransfer]:
    return [urm_modbus.address_change(old, new)]


READDRESSED: Mapping[str, Readdressing] = {
    **dict.fromkeys(("srf02", "srf08", "srf10", "srf235"), Readdressing(_devantech)),
    "i2cxl": Readdressing(_i2cxl),
    "srf02-serial": Readdressing(srf02_serial.address_change),
    "srf01": Readdressing(srf01.address_change),
    "urm07": Readdressing(urm07.address_change),
    **dict.fromkeys(("urm09", "urm13-i2c"), Readdressing(_urm, after_power_cycle=True)),
    **dict.fromkeys(("urm12", "urm13", "urm14", "urm15"), Readdressing(_urm_modbus, after_power_cycle=True)),
}
"""By driver."""
