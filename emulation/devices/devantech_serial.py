"""What Devantech's emulated rangers on serial lines share: two bytes make a command, the address first."""

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from random import Random
from typing import ClassVar

from echogrid.emulation.devices.serial_ranger import SerialRanger
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.scene import Echo

BAUD = 9600
INCH, CENTIMETRE = 0.0254, 0.01
OWN_SPEED = 343.0
"""m/s, which they take for centimetres and inches at any temperature."""
RANGING_NS = 65_000_000

_BURST, _VERSION, _RANGE = 0x5C, 0x5D, 0x5E
_MOVE = (0xA0, 0xAA, 0xA5)
"""The commands behind which the next one is taken for an address."""
_BURST_S = 200e-6
"""Eight cycles of 40 kHz."""


class DevantechSerial(SerialRanger):
    """Takes no notice of the line while it ranges. An address and a command can't be taken for each other:
    what is lost costs one command, and no more.

    It sends and listens with the same transducer: while that rings, it is deaf. A sound that is still there
    when it begins to hear reads as from just then; one that has gone is missed.
    """

    shares_line = True
    addresses: ClassVar[range]
    ranging_units: ClassVar[Mapping[int, float]]
    """m for the unit of each ranging command; 0: it gives the time of flight itself, in microseconds."""
    listening_units: ClassVar[Mapping[int, float]]
    """The same for commands that do all but ping."""

    def __init__(
        self,
        name: str,
        address: int,
        surroundings: Surroundings,
        random: Random,
        bits_per_byte: int,
    ) -> None:
        super().__init__(name, BAUD, surroundings, random, bits_per_byte)
        self.address = address
        self._revision = 0
        self._own_speed = OWN_SPEED
        self._range = bytes(2)
        self._unit = 0.0
        self._silent = self._awake = self._addressed = False
        self._pings = self._moved = 0

    def receive(self, data: bytes, now_ns: int) -> None:
        """Take commands for it; what another one is told is none of its business."""
        for byte in data:
            if self.ranging(now_ns) or (self.needs_breaks and not self._awake):
                continue
            if byte in self.addresses and not (self._addressed and self._moved == len(_MOVE)):
                self._addressed = byte == self.address
            elif self._addressed:
                self._addressed = self._awake = False
                self._obey(byte, now_ns)

    def receive_break(self, now_ns: int) -> None:
        """Listen to the next message."""
        self._awake = not self.ranging(now_ns)
        self._addressed = False

    def _obey(self, command: int, now_ns: int) -> None:
        if self._moved == len(_MOVE):
            self.address = command if command in self.addresses else self.address
            self._moved = 0
            return
        self._moved = self._moved + 1 if command == _MOVE[self._moved] else int(command == _MOVE[0])
        if command in self.ranging_units or command in self.listening_units:
            self._range_now(command, now_ns)
        elif command == _BURST:
            self.sonar.fire(now_ns)
        elif command == _VERSION:
            self.reply(bytes((self._revision,)), now_ns)
        elif command == _RANGE:
            self.reply(self._range, now_ns)
        else:
            self._order(command, now_ns)

    def _range_now(self, command: int, now_ns: int) -> None:
        self._silent = command in self.listening_units
        self._unit = self.listening_units[command] if self._silent else self.ranging_units[command]
        self._begin(now_ns, RANGING_NS, RANGING_NS, self._silent)

    def _hear(self, echoes: Sequence[Echo]) -> None:
        deaf_s = 2 * self._deaf_within() / self._own_speed
        flights = (2 * echo.distance / self.sonar.speed_of_sound for echo in echoes if echo.margin >= 0)
        heard = (max(at_s, deaf_s) for at_s in flights if deaf_s - _BURST_S < at_s <= RANGING_NS * 1e-9)
        self._range = self._in_unit(next(heard, 0.0))
        self._pings += not self._silent

    def _in_unit(self, flight_s: float) -> bytes:
        """A time of flight in the unit of the last ranging, high byte first."""
        value = flight_s * self._own_speed / 2 / self._unit if self._unit else flight_s * 1e6
        return min(round(value), 0xFFFF).to_bytes(2, "big")

    def _forget(self) -> None:
        self._range = bytes(2)
        self._unit = 0.0
        self._silent = self._awake = self._addressed = False
        self._pings = self._moved = 0

    @abstractmethod
    def _order(self, command: int, now_ns: int) -> None:
        """Do what only this model can."""

    @abstractmethod
    def _deaf_within(self) -> float:
        """How near (m) it hears nothing at present."""
