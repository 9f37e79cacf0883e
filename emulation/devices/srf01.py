"""An emulated Devantech SRF01: one wire, a break before each command, whole centimetres."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from random import Random
from typing import ClassVar

from echogrid.emulation.devices.devantech_serial import CENTIMETRE, INCH, OWN_SPEED, DevantechSerial
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.scene import Echo

_STATUS, _UNLOCK, _SET_ADVANCED, _CLEAR_ADVANCED = 0x5F, 0x61, 0x62, 0x63
_LOCKED, _ADVANCED = 0x01, 0x02
_UNLOCKED_MINIMUM, _PLAIN_MINIMUM = 0.18, 0.12
_ANSWERS = frozenset((0x53, 0x54, 0x59, 0x5A))
"""Ranging commands whose answer is sent when the ranging is over."""


@dataclass(frozen=True, slots=True)
class Srf01Options:
    """What differs between sensors of this kind."""

    address: int = 1
    """As it is delivered."""
    revision: int = 1
    advanced: int = 1
    """1: it hears down to zero when it is locked; so it is delivered."""
    locking_pings: int = 6
    """After which it is locked to its transducer: unknown, a guess."""
    speed_of_sound: float = OWN_SPEED
    """m/s, which it takes for centimetres and inches at any temperature: unknown, that of its kin."""

    def __post_init__(self) -> None:
        if self.address not in Srf01Sensor.addresses:
            raise ValueError(f"address {self.address} is not one of an SRF01 (1 to 16)")


class Srf01Sensor(DevantechSerial):
    """Listens behind a break only. Its address and its mode last; its lock is lost with its power."""

    one_wire = True
    addresses: ClassVar[range] = range(1, 17)
    ranging_units: ClassVar[Mapping[int, float]] = {
        **dict.fromkeys((0x50, 0x53), INCH),
        **dict.fromkeys((0x51, 0x54), CENTIMETRE),
    }
    listening_units: ClassVar[Mapping[int, float]] = {
        **dict.fromkeys((0x56, 0x59), INCH),
        **dict.fromkeys((0x57, 0x5A), CENTIMETRE),
    }

    def __init__(
        self,
        name: str,
        surroundings: Surroundings,
        random: Random,
        options: Srf01Options | None = None,
    ) -> None:
        self._options = options or Srf01Options()
        super().__init__(name, self._options.address, surroundings, random, bits_per_byte=10)
        self.needs_breaks = True
        self._revision = self._options.revision
        self._own_speed = self._options.speed_of_sound
        self._advanced = bool(self._options.advanced)
        self._answers = False

    def _order(self, command: int, now_ns: int) -> None:
        if command == _STATUS:
            status = _LOCKED * self._locked | _ADVANCED * self._advanced
            self.reply(bytes((status,)), now_ns)
        elif command == _UNLOCK:
            self._pings = 0
        elif command in (_SET_ADVANCED, _CLEAR_ADVANCED):
            self._advanced = command == _SET_ADVANCED

    def _range_now(self, command: int, now_ns: int) -> None:
        self._answers = command in _ANSWERS
        super()._range_now(command, now_ns)

    def _hear(self, echoes: Sequence[Echo]) -> None:
        super()._hear(echoes)
        if self._answers:
            self.reply(self._range, self._done_ns)

    def _forget(self) -> None:
        super()._forget()
        self._answers = False

    @property
    def _locked(self) -> bool:
        return self._pings >= self._options.locking_pings

    def _deaf_within(self) -> float:
        if not self._locked:
            return _UNLOCKED_MINIMUM
        return 0.0 if self._advanced else _PLAIN_MINIMUM
