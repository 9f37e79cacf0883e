"""An emulated CubeMars AK actuator in servo mode: a wheel on its shaft."""

import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import floor, tau
from random import Random

from echogrid.drivers.bus import NEVER_NS, CanFrame
from echogrid.emulation.devices.can_node import CanNode
from echogrid.emulation.devices.device import LOOKED_UP
from echogrid.emulation.faults import Verb

_STARTUP_NS = 400_000_000
"""From power-up until it sends: a guess."""
_ERPM_PER_TURN_PER_S = 60 * 21 * 9
"""21 pole pairs and a gear of 9, as in an AK80-9."""
_SLOPE_NS = 5_000_000
"""The speed is the mean over so long."""
_END = 32_000
"""0.1 deg: where one stops counting that does not wrap."""
_OVER_TEMPERATURE, _ENCODER_FAULT = 1, 5
_COOL, _HOT = 35, 96


@dataclass(frozen=True, slots=True)
class AkServoOptions:
    """How the actuator is configured, and what of it no manual says."""

    node: int = 0
    packet: int = 0x29
    """The identifier's bits above the node's eight."""
    gear: float = 1.0
    """Turns of its shaft for one of the wheel; negative if it counts backwards."""
    period_ns: int = 10_000_000
    ends: str = "wrap"
    """What the position does at its end: "wrap" as 16 bits do, or "stop" at 3200 deg."""

    def __post_init__(self) -> None:
        if not 0 <= self.node <= 0xFF:
            raise ValueError(f"node {self.node} does not fit eight bits")
        if not 0 <= self.packet <= 0x1F_FFFF:
            raise ValueError(f"packet {self.packet:#x} does not fit an extended identifier")
        if not 2_000_000 <= self.period_ns <= 1_000_000_000:
            raise ValueError(f"period_ns {self.period_ns}: it sends 1 to 500 times a second")
        if self.ends not in ("wrap", "stop"):
            raise ValueError(f"ends {self.ends!r}: the position can wrap or stop there")


class AkServo(CanNode):
    """Sends position, speed, current, temperature and error. The position counts from power-up.

    Commands are heard and not obeyed.
    """

    def __init__(
        self,
        name: str,
        angle: Callable[[int], float],
        random: Random,
        options: AkServoOptions = AkServoOptions(),
    ) -> None:
        super().__init__(name)
        self._angle = angle
        self._random = random
        self._options = options
        self._phase_ns = random.randrange(options.period_ns)
        self._start_ns = self._due_ns = NEVER_NS
        self._origin = 0.0

    def receive(self, frame: CanFrame, now_ns: int) -> None:
        """Nothing: a motor is not turned here."""

    def _verbs(self) -> Mapping[str, Verb]:
        return {**super()._verbs(), "overheated": LOOKED_UP, "encoder_lost": LOOKED_UP}

    def _power_up(self, now_ns: int) -> None:
        self._start_ns = now_ns + _STARTUP_NS

    def _power_down(self) -> None:
        self._start_ns = self._due_ns = NEVER_NS
        self.withdraw()

    def _next_ns(self) -> int:
        return min(self._start_ns, self._due_ns)

    def _step(self, now_ns: int) -> None:
        if now_ns >= self._start_ns:
            self._origin = self._angle(now_ns)
            self._due_ns = now_ns + self._phase_ns
            self._start_ns = NEVER_NS
        if now_ns >= self._due_ns:
            self._send(self._payload(now_ns), now_ns)
            self._due_ns += self._options.period_ns

    def _payload(self, now_ns: int) -> bytes:
        if "encoder_lost" in self.faults:
            return upload(0, 0, 0.0, _COOL, _ENCODER_FAULT)
        position, erpm = self._position(now_ns), self._erpm(now_ns)
        if "overheated" in self.faults:
            return upload(position, erpm, 0.0, _HOT, _OVER_TEMPERATURE)
        return upload(position, erpm, 0.0, _COOL, 0)

    def _erpm(self, now_ns: int) -> int:
        turned = self._turns(self._angle(now_ns) - self._angle(now_ns - _SLOPE_NS))
        return round(turned / _SLOPE_NS * 1e9 * _ERPM_PER_TURN_PER_S)

    def _turns(self, radians: float) -> float:
        return radians / tau * self._options.gear

    def _position(self, now_ns: int) -> int:
        tenths = floor(3600 * self._turns(self._angle(now_ns) - self._origin))
        return max(-_END, min(_END, tenths)) if self._options.ends == "stop" else tenths

    def _send(self, payload: bytes, now_ns: int) -> None:
        if "garbage" in self.faults:
            payload = self._random.randbytes(len(payload))
        identifier = self._options.packet << 8 | self._options.node
        self.post(CanFrame(identifier, payload, extended=True), now_ns + self._delay_ns())


def upload(position: int, erpm: int, amperes: float, celsius: int, error: int) -> bytes:
    """Position in 0.1 deg, which wraps as 16 bits do, electrical rpm, current, temperature, error."""
    wrapped = (position + (1 << 15)) % (1 << 16) - (1 << 15)
    return struct.pack(">hhhbB", wrapped, erpm // 10, round(amperes * 100), celsius, error)
