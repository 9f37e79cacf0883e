"""Devantech SRF02 in its serial mode: up to sixteen on one line, told to ping one by one."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from echogrid.drivers import devantech_serial
from echogrid.drivers.bus import SerialTransfer
from echogrid.drivers.commanded import CommandedRanger
from echogrid.drivers.conversation import Conversation
from echogrid.drivers.course import Course
from echogrid.drivers.devantech_serial import BAUD, LISTEN_CENTIMETRES, MICROSECONDS, DevantechLineMake
from echogrid.drivers.limits import require_between
from echogrid.drivers.make import Fired, Trouble
from echogrid.drivers.role import RangerRole

FIRST_MINIMUM = 0.28
"""m: within that it is deaf after power-up, until it has tuned itself;"""
TUNING_PINGS = 6
"""that takes so many pings. How far it has come can't be asked for sure in this mode."""
FIRST_ADDRESS, LAST_ADDRESS = 0, 15


def address_change(old: int, new: int) -> tuple[SerialTransfer, ...]:
    """The messages that give the SRF02 which hears them another address. Raises ValueError if it can't be."""
    require_between("address", new, FIRST_ADDRESS, LAST_ADDRESS)
    return devantech_serial.address_change(old, new)


class Srf02SerialMake(DevantechLineMake):
    """The SRF02's messages: the answer is the time of flight, there and back."""

    can_listen: ClassVar[bool] = True

    def __init__(self, role: RangerRole, settings: "Srf02Serial.Settings") -> None:
        metres = {MICROSECONDS: role.speed_of_sound * 1e-6 / 2, LISTEN_CENTIMETRES: 0.01}
        super().__init__(role, settings.address, metres)
        self._pings = 0

    def set_up(self) -> Course[SerialTransfer, Trouble | None]:
        """Look whether it is there; it may just have got its power."""
        self._pings = 0
        return (yield from super().set_up())

    def fire(self, listens: bool) -> Course[SerialTransfer, Fired]:
        """Start a ping, which tunes it a little more, or only listen."""
        self._pings += not listens
        return (yield from super().fire(listens))

    def _nearest(self) -> float:
        return FIRST_MINIMUM if self._pings <= TUNING_PINGS else 0.0


class Srf02Serial(CommandedRanger[SerialTransfer]):
    """One SRF02 on a serial line."""

    bus: ClassVar[str] = "serial"
    line: ClassVar[type[Conversation]] = Conversation
    identity: ClassVar[str] = "address"
    port_options: ClassVar[Mapping[str, object]] = {"baud": BAUD, "stop_bits": 2}

    @dataclass(frozen=True, slots=True)
    class Settings:
        """Its keys in a config file."""

        address: int = 0
        """As it is delivered."""

        def __post_init__(self) -> None:
            require_between("address", self.address, FIRST_ADDRESS, LAST_ADDRESS)

    def __init__(self, role: RangerRole, settings: Settings) -> None:
        super().__init__(role, Srf02SerialMake(role, settings))
