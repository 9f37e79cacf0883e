"""An emulated VESC: a wheel's motor behind its status messages."""

import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import floor, tau
from random import Random

from echogrid.drivers.bus import NEVER_NS, CanFrame
from echogrid.emulation.devices.can_node import CanNode
from echogrid.emulation.devices.device import LOOKED_UP
from echogrid.emulation.devices.shaft import Shaft
from echogrid.emulation.faults import Verb

_STATUSES = (9, 14, 15, 16, 27, 58)
"""STATUS to STATUS_6, by their bits in a set of messages."""
_STATUS, _STATUS_4, _STATUS_5 = 9, 16, 27
_SET_CURRENT, _SET_CURRENT_BRAKE, _SET_RPM = 1, 2, 3
_NOTIFY_BOOT = 57
_STARTUP_NS = 400_000_000
"""From power-up until it counts and sends: a guess."""
_NOTICE_NS = 500_000_000
"""From there to the boot notice: main.c sleeps so long."""
_SEND_NS = 50_000
"""How long a message keeps the thread that sends it: a guess. The thread then sleeps for its period."""
_HARDWARE = b"EMULATED"
_SLOPE_NS = 5_000_000
"""The speed is the mean over so long."""
_VOLTS = 48.1
_COOL, _HOT = 35.2, 96.5


@dataclass(frozen=True, slots=True)
class VescOptions:
    """How the controller is configured. Bit 0 of `messages` is STATUS, bit 5 is STATUS_6."""

    node: int = 0
    gear: float = 1.0
    """Turns of the motor for one of the wheel; negative if it counts backwards."""
    pole_pairs: int = 7
    messages: int = 0b010001
    """The first set: STATUS and STATUS_5. From the factory it is empty."""
    period_ns: int = 20_000_000
    slow_messages: int = 0b001000
    """The second set: STATUS_4."""
    slow_period_ns: int = 200_000_000
    origin: int = 0
    """What the tachometer begins with; a real one begins with 0."""
    timeout_ns: int = 500_000_000
    """Without a command for so long it lets the motor go."""
    least_erpm: int = 0
    """`s_pid_min_erpm`: told to turn more slowly it lets the motor go. From the factory 900."""

    def __post_init__(self) -> None:
        if not 0 <= self.node < 255:
            raise ValueError(f"node {self.node} is no VESC ID (0 to 254)")
        if self.pole_pairs < 1:
            raise ValueError(f"pole_pairs {self.pole_pairs}: a motor has at least one")
        if min(self.period_ns, self.slow_period_ns) < 1_000_000:
            raise ValueError("a set of messages is sent at most each millisecond")


class Vesc(CanNode):
    """Sends two sets of status messages, each with a rate of its own, and a notice after it has started.

    The tachometer counts sixths of an electrical turn from the start. Commands turn, brake or release its
    motor. Braking stops it whatever the current.
    """

    def __init__(
        self,
        name: str,
        angle: Callable[[int], float],
        random: Random,
        options: VescOptions = VescOptions(),
    ) -> None:
        super().__init__(name)
        self._angle = angle
        self._random = random
        self._options = options
        self._sets = (
            (options.messages, options.period_ns),
            (options.slow_messages, options.slow_period_ns),
        )
        self._phases_ns = [random.randrange(period_ns) for _, period_ns in self._sets]
        self._due_ns = [NEVER_NS, NEVER_NS]
        self._start_ns = self._notice_ns = NEVER_NS
        self._origin = 0.0
        self._shaft = Shaft.of(angle)
        self._timeout_ns = NEVER_NS

    def receive(self, frame: CanFrame, now_ns: int) -> None:
        """Obey a command, until its time-out; while it starts up it hears none."""
        packet, node = frame.identifier >> 8, frame.identifier & 0xFF
        commanded = packet in (_SET_CURRENT, _SET_CURRENT_BRAKE, _SET_RPM) and len(frame.data) == 4
        if not (frame.extended and commanded and node == self._options.node and self._start_ns == NEVER_NS):
            return
        (value,) = struct.unpack(">i", frame.data)
        self._timeout_ns = now_ns + self._options.timeout_ns
        if packet == _SET_RPM and abs(value) >= self._options.least_erpm:
            turns_per_s = value / 60 / self._options.pole_pairs
            self._shaft.drive(turns_per_s * tau / self._options.gear, now_ns)
        elif packet == _SET_CURRENT_BRAKE and value:
            self._shaft.drive(0.0, now_ns)
        else:
            self._shaft.release(now_ns)

    def lose_power(self, cause: str, now_ns: int) -> None:
        """Take its supply: nothing drives the shaft any more."""
        self._shaft.release(now_ns)
        super().lose_power(cause, now_ns)

    def _verbs(self) -> Mapping[str, Verb]:
        return {**super()._verbs(), "overheated": LOOKED_UP}

    def _power_up(self, now_ns: int) -> None:
        self._start_ns = now_ns + _STARTUP_NS
        self._notice_ns = self._start_ns + _NOTICE_NS

    def _power_down(self) -> None:
        self._due_ns = [NEVER_NS, NEVER_NS]
        self._start_ns = self._notice_ns = self._timeout_ns = NEVER_NS
        self.withdraw()

    def _next_ns(self) -> int:
        return min(self._start_ns, self._notice_ns, self._timeout_ns, *self._due_ns)

    def _step(self, now_ns: int) -> None:
        if now_ns >= self._start_ns:
            self._origin = self._angle(now_ns)
            self._due_ns = [now_ns + phase_ns for phase_ns in self._phases_ns]
            self._start_ns = NEVER_NS
        if now_ns >= self._timeout_ns:
            self._shaft.release(now_ns)
            self._timeout_ns = NEVER_NS
        for index, (messages, period_ns) in enumerate(self._sets):
            if now_ns >= self._due_ns[index]:
                sent = [packet for bit, packet in enumerate(_STATUSES) if messages >> bit & 1]
                for packet in sent:
                    self._send(packet, self._payload(packet, now_ns), now_ns)
                self._due_ns[index] += period_ns + _SEND_NS * len(sent)
        if now_ns >= self._notice_ns:
            self._send(_NOTIFY_BOOT, _HARDWARE, now_ns)
            self._notice_ns = NEVER_NS

    def _payload(self, packet: int, now_ns: int) -> bytes:
        if packet == _STATUS:
            return status(round(self._erpm(now_ns)), 0.0, 0.0)
        if packet == _STATUS_4:
            return status_4(_HOT if "overheated" in self.faults else _COOL, _COOL, 0.0, 0.0)
        if packet == _STATUS_5:
            return status_5(self._tachometer(now_ns), _VOLTS)
        return bytes(8)

    def _electrical_turns(self, radians: float) -> float:
        return radians / tau * self._options.gear * self._options.pole_pairs

    def _tachometer(self, now_ns: int) -> int:
        turned = self._angle(now_ns) - self._origin
        return self._options.origin + floor(6 * self._electrical_turns(turned))

    def _erpm(self, now_ns: int) -> float:
        turned = self._angle(now_ns) - self._angle(now_ns - _SLOPE_NS)
        return self._electrical_turns(turned) / _SLOPE_NS * 60e9

    def _send(self, packet: int, payload: bytes, now_ns: int) -> None:
        if "garbage" in self.faults:
            payload = self._random.randbytes(len(payload))
        identifier = packet << 8 | self._options.node
        self.post(CanFrame(identifier, payload, extended=True), now_ns + self._delay_ns())


def status(erpm: int, amperes: float, duty: float) -> bytes:
    """Packet 9: electrical turns per minute, motor current, duty cycle (-1 to 1)."""
    return struct.pack(">ihh", erpm, round(amperes * 10), round(duty * 1000))


def status_4(fet_c: float, motor_c: float, amperes: float, position_deg: float) -> bytes:
    """Packet 16: temperatures, current from the supply, and the position controller's angle."""
    return struct.pack(
        ">hhhh", round(fet_c * 10), round(motor_c * 10), round(amperes * 10), round(position_deg * 50)
    )


def status_5(tachometer: int, volts: float) -> bytes:
    """Packet 27: the tachometer, which wraps at 2^31, and the supply."""
    wrapped = (tachometer + (1 << 31)) % (1 << 32) - (1 << 31)
    return struct.pack(">ihh", wrapped, round(volts * 10), 0)
