"""A drive that confirms what it is told, played by hand, for the tests of its driver."""

from dataclasses import replace
from struct import pack
from typing import Any

from echogrid.drivers.bus import CanFrame
from echogrid.drivers.cia402 import Cia402Axis
from echogrid.drivers.cia402_settings import Cia402Settings
from echogrid.drivers.device import State
from echogrid.drivers.readings import WheelReading
from echogrid.drivers.role import WheelRole

MS = 1_000_000
NODE = 2
ROLE = WheelRole("left", fastest=100.0)
PER_TURN = 1000
OPERATIONAL, PRE_OPERATIONAL, BOOT = 0x05, 0x7F, 0x00
DISABLED, READY, SWITCHED_ON, ENABLED, FAULT = 0x0250, 0x0231, 0x0233, 0x0237, 0x0218


def motion(counts: int, velocity: int = 0) -> CanFrame:
    return CanFrame(0x182, pack("<ii", counts, velocity))


def status(word: int) -> CanFrame:
    return CanFrame(0x282, word.to_bytes(2, "little"))


def heartbeat(state: int = OPERATIONAL) -> CanFrame:
    return CanFrame(0x702, bytes((state,)))


def emergency(code: int) -> CanFrame:
    return CanFrame(0x082, code.to_bytes(2, "little") + bytes(6))


class Bench:
    """The driver before a drive which confirms everything but what it is to refuse."""

    def __init__(self, role: WheelRole = ROLE, **settings: Any) -> None:
        chosen = {"node": NODE, "counts_per_turn": PER_TURN, "tpdo": 1, "status_tpdo": 2, **settings}
        self.device = Cia402Axis(role, Cia402Settings(**chosen))
        self.now_ns = 0
        self.device_type = 0x00020192
        self.mute = False
        self.refused: dict[tuple[int, int], int] = {}
        self.written: dict[tuple[int, int], int] = {}
        self.sent: list[CanFrame] = []
        self.readings: list[WheelReading] = []

    def hear(self, *frames: CanFrame, after_ms: int = 1) -> list[WheelReading]:
        """Some time later the drive sends these; what it is told meanwhile is confirmed."""
        self.now_ns += after_ms * MS
        received = [replace(frame, stamp_ns=self.now_ns) for frame in frames]
        before = len(self.readings)
        while True:
            step = self.device.step(self.now_ns, received)
            self.sent += step.send
            self.readings += [each for each in step.readings if isinstance(each, WheelReading)]
            received = [reply for frame in step.send for reply in self._replies(frame)]
            if not received:
                return self.readings[before:]

    def _replies(self, frame: CanFrame) -> list[CanFrame]:
        if frame.identifier != 0x600 + NODE or self.mute:
            return []
        key = int.from_bytes(frame.data[1:3], "little"), frame.data[3]
        address = frame.data[1:4]
        if key in self.refused:
            data = b"\x80" + address + self.refused[key].to_bytes(4, "little")
        elif frame.data[0] == 0x40:
            data = b"\x43" + address + self.device_type.to_bytes(4, "little")
        else:
            self.written[key] = int.from_bytes(frame.data[4:], "little")
            data = b"\x60" + address + bytes(4)
        return [CanFrame(0x580 + NODE, data, stamp_ns=self.now_ns)]

    def ready(self) -> "Bench":
        """The driver has set the drive up, and the drive is operational."""
        self.hear(heartbeat(BOOT))
        self.hear(heartbeat(), status(DISABLED))
        return self

    def of(self, identifier: int) -> list[bytes]:
        """What the driver has sent with that identifier."""
        return [frame.data for frame in self.sent if frame.identifier == identifier]

    @property
    def state(self) -> State:
        return self.device.health(self.now_ns).state

    @property
    def message(self) -> str:
        return self.device.health(self.now_ns).message

    def count(self, name: str) -> int:
        return self.device.health(self.now_ns).counts[name]
