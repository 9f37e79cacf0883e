"""An emulated DFRobot URM07, URM06 or URM04 on a UART: frames with an address and a sum."""

from collections.abc import Sequence
from dataclasses import dataclass
from random import Random

from echogrid.emulation.devices.serial_ranger import SerialRanger
from echogrid.emulation.devices.sonar import first_heard
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.scene import Echo

_TRIGGER, _DISTANCE, _TEMPERATURE, _MOVE = 0x01, 0x02, 0x03, 0x55
_HEAD = b"\x55\xaa"
_ANYBODY = 0xAB
"""The address at which every one answers."""
_ADDRESSES = range(0x11, 0x81)
_MOST_DATA = 2
_MOVED = 0xCC
_NOTHING = 0xFFFF
_GAP_BYTES = 5
"""After so many bytes' time without one a frame begins anew: unknown, a guess."""
_ZERO_CELSIUS_K = 273.15
_SPEED_AT_ZERO = 331.3
"""m/s in dry air."""


@dataclass(frozen=True, slots=True)
class Urm07Options:
    """What differs between the models."""

    address: int = 0x11
    """As it is delivered."""
    baud: int = 19_200
    unit_mm: float = 10.0
    triggers: int = 0
    """1: as the URM04, it ranges at command 1 and tells at command 2; else command 2 does both."""
    reach: float = 7.5
    """m."""
    nearest: float = 0.2
    """m: it is deaf to what is nearer."""
    ranging_ns: int = 53_000_000
    """The URM07's time for 8 m and something; a real one replies as soon as the echo is there."""

    def __post_init__(self) -> None:
        if self.address not in _ADDRESSES:
            raise ValueError(f"address {self.address:#x} is not one of a URM07 (0x11 to 0x80)")
        if self.baud <= 0 or self.ranging_ns <= 0 or self.unit_mm <= 0:
            raise ValueError("baud, ranging_ns and unit_mm must be above 0")


class Urm07Sensor(SerialRanger):
    """Takes no frame while it ranges. It corrects for the temperature, so its distances are true."""

    shares_line = True

    def __init__(
        self,
        name: str,
        surroundings: Surroundings,
        random: Random,
        options: Urm07Options = Urm07Options(),
    ) -> None:
        super().__init__(name, options.baud, surroundings, random)
        self.address = options.address
        self._options = options
        self._gap_ns = _GAP_BYTES * self.bits_per_byte * 1_000_000_000 // options.baud
        self._frame = bytearray()
        self._received_ns = 0
        self._counts = _NOTHING

    def receive(self, data: bytes, now_ns: int) -> None:
        """Take frames; what is none is thrown away up to the next head."""
        if now_ns - self._received_ns > self._gap_ns:
            self._frame.clear()
        self._received_ns = now_ns
        for byte in data:
            self._frame.append(byte)
            self._skip()
            if len(self._frame) >= 6 and len(self._frame) == 6 + self._frame[3]:
                frame = bytes(self._frame)
                self._frame.clear()
                if frame == _summed(frame[:-1]) and not self.ranging(now_ns):
                    self._take(frame, now_ns)

    def _skip(self) -> None:
        """Throw away what can't be the beginning of a frame."""
        while self._frame and not _may_begin(bytes(self._frame)):
            del self._frame[0]

    def _take(self, frame: bytes, now_ns: int) -> None:
        address, command, data = frame[2], frame[4], frame[5:-1]
        if address not in (self.address, _ANYBODY):
            return
        if command == (_TRIGGER if self._options.triggers else _DISTANCE):
            self._begin(now_ns, self._options.ranging_ns, self._options.ranging_ns)
        elif command == _DISTANCE:
            self._tell(_DISTANCE, self._counts, now_ns)
        elif command == _TEMPERATURE:
            self._tell(_TEMPERATURE, round(10 * self._celsius()) & 0xFFFF, now_ns)
        elif command == _MOVE and len(data) == 1 and data[0] in _ADDRESSES:
            self.address = data[0]
            self.reply(_summed(_HEAD + bytes((self.address, 1, _MOVE, _MOVED))), now_ns)

    def _tell(self, command: int, word: int, start_ns: int) -> None:
        self.reply(_summed(_HEAD + bytes((self.address, 2, command)) + word.to_bytes(2, "big")), start_ns)

    def _hear(self, echoes: Sequence[Echo]) -> None:
        distance = first_heard(echoes, self._options.reach, self._options.nearest)
        self._counts = _NOTHING if distance is None else round(distance * 1000 / self._options.unit_mm)
        if not self._options.triggers:
            self._tell(_DISTANCE, self._counts, self._done_ns)

    def _celsius(self) -> float:
        """The temperature of the world's air, by its speed of sound."""
        return ((self.sonar.speed_of_sound / _SPEED_AT_ZERO) ** 2 - 1) * _ZERO_CELSIUS_K

    def _forget(self) -> None:
        self._frame.clear()
        self._counts = _NOTHING


def _may_begin(frame: bytes) -> bool:
    """Whether a frame may begin so: by its head and its length."""
    return _HEAD.startswith(frame[:2]) and (len(frame) < 4 or frame[3] <= _MOST_DATA)


def _summed(body: bytes) -> bytes:
    return body + bytes((sum(body) & 0xFF,))
