"""A CAN bus of the kernel's, watched as the service watches it."""

import gc
import re
import socket
import struct
import time
from collections.abc import Callable

from echogrid.drivers.device import State
from echogrid.drivers.transports.can import CanPort
from hil_tests.kernel import command
from hil_tests.pumping import WAIT_S, Readout, odrive

VIRTUAL, CONTROLLED = "vcan_sv", "can_sv"
"""An interface without a controller, and one with."""
BITRATE = 250_000
HEARTBEAT, ESTIMATES = "t00180000000001000000", "t00980000000000000000"
"""Of an ODrive that is idle."""
_PACKET = struct.Struct("=IB3x8s")


class Watch:
    """An ODrive's driver on an interface, kept going."""

    def __init__(self, interface: str, bitrate: int = BITRATE) -> None:
        self.port = CanPort(interface, bitrate=bitrate)
        self.readout = Readout(self.port, odrive())
        self.pump = self.readout.pump
        self.pump.turn()
        assert self.pump.trouble == ""

    def close(self) -> None:
        """Let the port go."""
        self.readout.close()
        gc.collect()

    def until(self, done: Callable[[], bool], meanwhile: Callable[[], None] = lambda: None) -> float:
        """Go on until it is so; how long that took, s. Raises AssertionError after a while."""
        began_s = time.monotonic()
        while not done():
            assert time.monotonic() < began_s + WAIT_S, (self.health, self.pump.trouble)
            self.pump.turn()
            meanwhile()
        return time.monotonic() - began_s

    def until_state(self, state: State) -> str:
        """Go on until the bus is so; what it says then."""
        self.until(lambda: self.health[0] is state)
        return self.health[1]

    def until_read(self, sending: Callable[[], None]) -> float:
        """Go on until the wheel is read again; how long that took, s."""
        self.readout.readings.clear()
        lasted_s = self.until(lambda: bool(self.readout.readings), sending)
        assert self.pump.trouble == ""
        return lasted_s

    @property
    def health(self) -> tuple[State, str]:
        """The bus's."""
        health = self.port.health(time.monotonic_ns())
        return health.state, health.message

    @property
    def counts(self) -> dict[str, int]:
        """The bus's."""
        return dict(self.port.health(time.monotonic_ns()).counts)


def send(identifier: int, data: bytes = b"") -> None:
    """By a socket of the kernel's own, on the virtual interface."""
    with socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as sender:
        sender.bind((VIRTUAL,))
        sender.send(_PACKET.pack(identifier, 8, data))


def mends(trouble: str) -> list[str]:
    """The commands that a message advises, without sudo."""
    return re.findall(r"sudo (ip [^&()]*\w)", trouble)


def mend(trouble: str) -> None:
    """Do what it says. The kernel's slcan driver refuses restart-ms, as the message allows for."""
    for line in mends(trouble):
        command(*line.replace(" restart-ms 100", "").split())
