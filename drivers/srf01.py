"""Devantech SRF01: a ranger on one wire for both directions, told to ping by a break and two bytes."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from echogrid.drivers import devantech_serial
from echogrid.drivers.bus import SerialTransfer
from echogrid.drivers.commanded import CommandedRanger
from echogrid.drivers.conversation import Conversation
from echogrid.drivers.course import Course
from echogrid.drivers.devantech_serial import (
    BAUD,
    CENTIMETRES,
    LISTEN_CENTIMETRES,
    DevantechLineMake,
    never,
)
from echogrid.drivers.limits import require_between
from echogrid.drivers.make import Trouble
from echogrid.drivers.role import RangerRole
from echogrid.drivers.serial_talk import unanswered

STATUS = 0x5F
"""The command for one byte:"""
LOCKED, ADVANCED = 0x01, 0x02
"""it has tuned itself to its transducer; it may then hear all the way down to zero."""
UNLOCKED_MINIMUM, PLAIN_MINIMUM = 0.18, 0.12
"""m: how near it hears before it is locked, and then without the advanced mode."""
OWN_SPEED = 343.0
"""m/s."""
FIRST_ADDRESS, LAST_ADDRESS = 1, 16


def address_change(old: int, new: int) -> tuple[SerialTransfer, ...]:
    """The messages that give the SRF01 which hears them another address. Raises ValueError if it can't be."""
    require_between("address", new, FIRST_ADDRESS, LAST_ADDRESS)
    return devantech_serial.address_change(old, new, (devantech_serial.BREAK,))


class Srf01Make(DevantechLineMake):
    """The SRF01's messages: the answer is in whole centimetres."""

    can_listen: ClassVar[bool] = True

    def __init__(self, role: RangerRole, settings: "Srf01.Settings") -> None:
        centimetre = 0.01 * role.speed_of_sound / settings.speed_of_sound_m_s
        super().__init__(
            role, settings.address, {CENTIMETRES: centimetre, LISTEN_CENTIMETRES: centimetre}, one_wire=True
        )
        self._status = 0

    def set_up(self) -> Course[SerialTransfer, Trouble | None]:
        """Look whether it is there, and how near it hears."""
        self._pinged_m = None
        result = yield from self._read(STATUS, 1, never)
        if result.errno:
            return unanswered(self.where, result, BAUD)
        self._status = result.data[0]
        return None

    def collect(self) -> Course[SerialTransfer, bytes]:
        """The answer; until it is locked its status is asked for, too."""
        data = yield from super().collect()
        if data and not self._status & LOCKED:
            result = yield from self._read(STATUS, 1, lambda data: data[0] == self._status)
            self._status = self._status if result.errno else result.data[0]
        return data

    def _nearest(self) -> float:
        if not self._status & LOCKED:
            return UNLOCKED_MINIMUM
        return 0.0 if self._status & ADVANCED else PLAIN_MINIMUM


class Srf01(CommandedRanger[SerialTransfer]):
    """One SRF01."""

    bus: ClassVar[str] = "serial"
    line: ClassVar[type[Conversation]] = Conversation
    identity: ClassVar[str] = "address"
    port_options: ClassVar[Mapping[str, object]] = {"baud": BAUD}

    @dataclass(frozen=True, slots=True)
    class Settings:
        """Its keys in a config file."""

        address: int = 1
        """As it is delivered."""
        speed_of_sound_m_s: float = OWN_SPEED
        """With which it makes centimetres of times: not documented, so that of its kin."""

        def __post_init__(self) -> None:
            require_between("address", self.address, FIRST_ADDRESS, LAST_ADDRESS)
            require_between("speed_of_sound_m_s", self.speed_of_sound_m_s, 300.0, 400.0)

    def __init__(self, role: RangerRole, settings: Settings) -> None:
        super().__init__(role, Srf01Make(role, settings))
