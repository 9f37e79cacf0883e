"""An emulated ODrive axis, as firmware 0.6 (Pro, S1, Micro) speaks CANSimple."""

import re
import struct
from collections.abc import Callable
from dataclasses import dataclass
from random import Random

from echogrid.emulation.devices.cansimple_axis import CansimpleAxis, State, require_node

_VERSION = 0x000
_PROTOCOL = 2
_HARDWARE = (4, 4, 58)
"""A Pro."""
_INITIALIZING, _MISSING_ESTIMATE, _DRV_FAULT = 0x1, 0x8, 0x20
_WATCHDOG = 0x1000000
_SUCCESS, _BUSY, _DISARMED = 0, 1, 3
_NUMBERS = re.compile(r"(\d{1,2})\.(\d{1,2})\.(\d{1,2})", re.ASCII)


@dataclass(frozen=True, slots=True)
class ODrive06Options:
    """How the axis is configured."""

    node: int = 0
    gear: float = 1.0
    """Turns of the encoder for one of the wheel; negative if it counts backwards."""
    heartbeat_ns: int = 100_000_000
    estimates_ns: int = 10_000_000
    watchdog: bool = False
    """Whether it stops, with an error, when no frame has come for `watchdog_ns`; from the factory not."""
    watchdog_ns: int = 500_000_000
    version: str = "0.6.10"
    """Of its firmware, as it tells it."""

    def __post_init__(self) -> None:
        require_node(self.node)
        if not _NUMBERS.fullmatch(self.version):
            raise ValueError(f"version {self.version!r} is none: expected one like '0.6.10'")


class ODrive06Axis(CansimpleAxis):
    """Tells its version on request, and its errors as one number.

    That its watchdog is at work in the closed loop only is a guess.
    """

    _idle_expires = False

    def __init__(
        self,
        name: str,
        angle: Callable[[int], float],
        random: Random,
        options: ODrive06Options = ODrive06Options(),
    ) -> None:
        super().__init__(name, angle, random, options)
        major, minor, revision = map(int, options.version.split("."))
        self._version = version((major, minor, revision))

    def _heartbeat(self, now_ns: int) -> bytes:
        state = self.state(now_ns)
        failed = "motor_failed" in self.faults
        error = (
            _INITIALIZING * (state == State.UNDEFINED)
            | _MISSING_ESTIMATE * ("encoder_lost" in self.faults)
            | _DRV_FAULT * failed
            | _WATCHDOG * self._expired
        )
        result = _DISARMED if failed else _BUSY if state == State.STARTUP else _SUCCESS
        return heartbeat(state, error=error, result=result)

    def _told(self, command: int, now_ns: int) -> bytes:
        return self._version if command == _VERSION else super()._told(command, now_ns)

    def _position_in(self, data: bytes) -> float:
        (turns,) = struct.unpack("<f", data)
        return float(turns)


def heartbeat(
    state: State, *, error: int = 0, result: int = _SUCCESS, trajectory_done: bool = False
) -> bytes:
    """Command 0x001 of firmware 0.6: the axis's errors, its state, how its last procedure ended."""
    return (error | state << 32 | result << 40 | trajectory_done << 48).to_bytes(8, "little")


def version(firmware: tuple[int, int, int]) -> bytes:
    """Command 0x000: the versions of protocol, hardware and firmware, which is a released one."""
    return bytes((_PROTOCOL, *_HARDWARE, *firmware, 0))
