"""A port by kind and address."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from echogrid.drivers.bus import I2cTransfer, IioRead, Port
from echogrid.drivers.limits import require_between
from echogrid.drivers.transports import iio_socket
from echogrid.drivers.transports.can import CanPort
from echogrid.drivers.transports.i2c import I2cPort
from echogrid.drivers.transports.i2c_kernel import KernelAdapter
from echogrid.drivers.transports.i2c_socket import SocketAdapter
from echogrid.drivers.transports.iio import IioPort
from echogrid.drivers.transports.iio_sysfs import SysfsAdapter
from echogrid.drivers.transports.serial import SerialPort
from echogrid.drivers.transports.transfers import Adapter

SOCKET = "unix:"
CAN_OPTIONS = ("interface", "bitrate", "fd", "listen_only")
NO_OPTIONS: Mapping[str, Any] = MappingProxyType({})


def make_port(kind: str, address: str, options: Mapping[str, Any] = NO_OPTIONS) -> Port[Any, Any]:
    """The port, not yet open. Raises ValueError, which names the option, if it cannot be.

    serial: address is a path; options baud, stop_bits, parity.
    i2c: address is a path (/dev/i2c-1), or unix:PATH for an emulated bus; options timeout_s.
    can: address is a channel of python-can; options interface, bitrate, fd, and what else it takes.
    iio: address is a path (/sys/bus/iio/devices), or unix:PATH for emulated devices; no options.
    """
    if kind == "serial":
        _require_known(options, "baud", "stop_bits", "parity")
        return SerialPort(address, **options)
    if kind == "i2c":
        _require_known(options, "timeout_s")
        return I2cPort(_adapter(address, **options))
    if kind == "can":
        own = {key: value for key, value in options.items() if key in CAN_OPTIONS}
        more = {key: value for key, value in options.items() if key not in own}
        return CanPort(address, **own, more=more)
    if kind == "iio":
        _require_known(options)
        return IioPort(_iio_adapter(address))
    raise ValueError(f"kind is {kind!r}: expected 'serial', 'i2c', 'can' or 'iio'")


def open_port(kind: str, address: str, options: Mapping[str, Any] = NO_OPTIONS) -> Port[Any, Any]:
    """The port of make_port, opened. Raises PortError, which names the port and the mend."""
    port = make_port(kind, address, options)
    port.open()
    return port


def _iio_adapter(address: str) -> Adapter[IioRead]:
    if address.startswith(SOCKET):
        return iio_socket.SocketAdapter(address.removeprefix(SOCKET))
    return SysfsAdapter(address)


def _adapter(address: str, timeout_s: float = 0.1) -> Adapter[I2cTransfer]:
    require_between("timeout_s", timeout_s, 0.01, 10.0)
    if address.startswith(SOCKET):
        return SocketAdapter(address.removeprefix(SOCKET), timeout_s)
    return KernelAdapter(address, timeout_s)


def _require_known(options: Mapping[str, Any], *known: str) -> None:
    for key in options:
        if key not in known:
            raise ValueError(f"{key} is no option of this port: expected {', '.join(known) or 'none'}")
