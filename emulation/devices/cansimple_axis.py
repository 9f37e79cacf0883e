"""An emulated axis that speaks CANSimple, as much of it as all firmwares of ODrive have in common."""

import struct
from abc import abstractmethod
from collections.abc import Callable, Mapping
from enum import IntEnum
from math import tau
from random import Random
from typing import Protocol

from echogrid.drivers.bus import NEVER_NS, CanFrame
from echogrid.emulation.devices.can_node import CanNode
from echogrid.emulation.devices.device import LOOKED_UP
from echogrid.emulation.devices.shaft import Shaft
from echogrid.emulation.faults import Verb

_HEARTBEAT = 0x001
_SET_STATE = 0x007
_ESTIMATES = 0x009
_SET_MODE = 0x00B
_SET_VELOCITY = 0x00D
_REBOOT = 0x016
_CLEAR_ERRORS = 0x018
_SET_POSITION = 0x019
_VELOCITY_CONTROL = 2
_STARTUP_NS = 200_000_000
"""From power-up to the state STARTUP, and again from there to IDLE: a guess."""


class State(IntEnum):
    """What the axis does, as in its heartbeat."""

    UNDEFINED = 0
    IDLE = 1
    STARTUP = 2
    CLOSED_LOOP = 8


def require_node(node: int) -> None:
    """Raise ValueError unless the node fits."""
    if not 0 <= node < 64:
        raise ValueError(f"node {node} does not fit a standard identifier (0 to 63)")


class AxisOptions(Protocol):
    """What the options of every firmware have."""

    @property
    def node(self) -> int:
        """Its identifier on the bus."""
        ...

    @property
    def gear(self) -> float:
        """Turns of the encoder for one of the wheel."""
        ...

    @property
    def heartbeat_ns(self) -> int:
        """From heartbeat to heartbeat."""
        ...

    @property
    def estimates_ns(self) -> int:
        """From estimates to estimates."""
        ...

    @property
    def watchdog(self) -> bool:
        """Whether it stops when no frame comes."""
        ...

    @property
    def watchdog_ns(self) -> int:
        """For how long none may come."""
        ...


class CansimpleAxis(CanNode):
    """Sends its heartbeat and its estimates by itself; answers requests, reboots, is set to positions.

    In the closed loop and in velocity control its motor turns the shaft at the velocity that it is sent.

    The position counts from power-up. Until the axis is IDLE, and while the encoder is lost, it is not valid:
    the estimates are then 0.0, as if the wheel stood at its origin.
    """

    _idle_expires = True
    """Whether the watchdog is at work in IDLE, too."""

    def __init__(
        self,
        name: str,
        angle: Callable[[int], float],
        random: Random,
        options: AxisOptions,
    ) -> None:
        super().__init__(name)
        self._angle = angle
        self._random = random
        self._axis = options
        self._phase_ns = random.randrange(options.estimates_ns)
        self._powered_ns = 0
        self._origin = 0.0
        self._sampled_ns = 0
        self._turns = self._velocity = 0.0
        self._heartbeat_ns = self._estimates_ns = NEVER_NS
        self._shaft = Shaft.of(angle)
        self._mode = 0
        self._closed = self._expired = False
        self._fed_ns = NEVER_NS

    def receive(self, frame: CanFrame, now_ns: int) -> None:
        """Answer a request (remote, or without data), or obey. Whatever comes feeds the watchdog."""
        if frame.extended or frame.identifier >> 5 != self._axis.node:
            return
        command = frame.identifier & 0x1F
        self._feed(now_ns)
        self._obey(command, frame, now_ns)
        asked = frame.remote or not frame.data
        if command == _REBOOT and not any(frame.data):
            self.reboot(now_ns)
        elif asked and (payload := self._told(command, now_ns)):
            self._send(command, payload, now_ns)
        elif command == _SET_POSITION and len(frame.data) >= 4:
            self._sample(now_ns)
            turns = self._position_in(frame.data[:4])
            self._origin -= (turns - self._turns) * tau / self._axis.gear
            self._turns = turns

    def _obey(self, command: int, frame: CanFrame, now_ns: int) -> None:
        """What has to do with the motor."""
        if command == _CLEAR_ERRORS and not frame.remote:
            self._expired = False
        if len(frame.data) != 8:
            return
        (first,) = struct.unpack("<I4x", frame.data)
        if command == _SET_MODE:
            self._mode = first
        elif command == _SET_STATE:
            self._set_state(first, now_ns)
        elif command == _SET_VELOCITY and self._closed and self._mode == _VELOCITY_CONTROL:
            (velocity,) = struct.unpack("<f", frame.data[:4])
            self._shaft.drive(velocity * tau / self._axis.gear, now_ns)

    def _set_state(self, state: int, now_ns: int) -> None:
        """The closed loop is for an axis that is well."""
        able = self._valid(now_ns) and not self._expired and "motor_failed" not in self.faults
        if state == State.CLOSED_LOOP and able:
            self._closed = True
        elif state == State.IDLE:
            self._open_loop(now_ns)

    def _open_loop(self, now_ns: int) -> None:
        if self._closed:
            self._shaft.release(now_ns)
        self._closed = False

    def _feed(self, now_ns: int) -> None:
        if self._axis.watchdog:
            self._fed_ns = now_ns + self._axis.watchdog_ns

    def _fail(self, now_ns: int) -> None:
        """Fault `motor_failed`, `encoder_lost`: it drives no more."""
        self._open_loop(now_ns)

    def reboot(self, now_ns: int) -> None:
        """Start up anew: the position begins at 0 where the wheel is."""
        self.lose_power("reboot", now_ns)
        self.restore_power("reboot", now_ns)

    def lose_power(self, cause: str, now_ns: int) -> None:
        """Take its supply: nothing drives the shaft any more."""
        self._open_loop(now_ns)
        super().lose_power(cause, now_ns)

    def state(self, now_ns: int) -> State:
        """What the axis does: it starts up for a while before it is IDLE."""
        age_ns = now_ns - self._powered_ns
        if age_ns < _STARTUP_NS:
            return State.UNDEFINED
        if age_ns < 2 * _STARTUP_NS:
            return State.STARTUP
        return State.CLOSED_LOOP if self._closed else State.IDLE

    def _verbs(self) -> Mapping[str, Verb]:
        failing = Verb(self._fail, LOOKED_UP.end)
        return {**super()._verbs(), "encoder_lost": failing, "motor_failed": failing}

    def _power_up(self, now_ns: int) -> None:
        self._powered_ns = self._sampled_ns = now_ns
        self._mode, self._closed, self._expired = 0, False, False
        self._feed(now_ns)
        self._origin = self._angle(now_ns)
        self._turns = self._velocity = 0.0
        self._heartbeat_ns = now_ns
        self._estimates_ns = now_ns + self._phase_ns

    def _power_down(self) -> None:
        self._heartbeat_ns = self._estimates_ns = self._fed_ns = NEVER_NS
        self.withdraw()

    def _next_ns(self) -> int:
        return min(self._heartbeat_ns, self._estimates_ns, self._fed_ns)

    def _step(self, now_ns: int) -> None:
        if now_ns >= self._fed_ns:
            self._fed_ns = NEVER_NS
            self._expired |= self._closed or self._idle_expires
            self._open_loop(now_ns)
        if now_ns >= self._heartbeat_ns:
            self._send(_HEARTBEAT, self._heartbeat(now_ns), now_ns)
            self._heartbeat_ns += self._axis.heartbeat_ns
        if now_ns >= self._estimates_ns:
            self._send(_ESTIMATES, self._estimates(now_ns), now_ns)
            self._estimates_ns += self._axis.estimates_ns

    @abstractmethod
    def _heartbeat(self, now_ns: int) -> bytes:
        """What it says of itself."""

    @abstractmethod
    def _position_in(self, data: bytes) -> float:
        """The position (rev) which it is set to by 4 bytes."""

    def _told(self, command: int, now_ns: int) -> bytes:
        """The answer to a request; empty if there is none."""
        return self._estimates(now_ns) if command == _ESTIMATES else b""

    def _estimates(self, now_ns: int) -> bytes:
        self._sample(now_ns)
        return estimates(self._turns, self._velocity) if self._valid(now_ns) else estimates(0.0, 0.0)

    def _sample(self, now_ns: int) -> None:
        """Look at the encoder; the velocity is the mean since the last look."""
        if now_ns <= self._sampled_ns:
            return
        turns = (self._angle(now_ns) - self._origin) / tau * self._axis.gear
        self._velocity = (turns - self._turns) / (now_ns - self._sampled_ns) * 1e9
        self._turns, self._sampled_ns = turns, now_ns

    def _valid(self, now_ns: int) -> bool:
        return self.state(now_ns) in (State.IDLE, State.CLOSED_LOOP) and "encoder_lost" not in self.faults

    def _send(self, command: int, payload: bytes, now_ns: int) -> None:
        if "garbage" in self.faults:
            payload = self._random.randbytes(len(payload))
        self.post(CanFrame(self._axis.node << 5 | command, payload), now_ns + self._delay_ns())


def estimates(turns: float, velocity: float) -> bytes:
    """Command 0x009: position (rev) and velocity (rev/s)."""
    return struct.pack("<ff", turns, velocity)
