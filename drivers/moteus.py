"""moteus motor controllers: asked for their position again and again, by CAN-FD."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from typing import ClassVar

from echogrid.drivers.bus import CanFrame
from echogrid.drivers.device import Health, Line, State, Step
from echogrid.drivers.freshness import is_old
from echogrid.drivers.limits import require_between
from echogrid.drivers.moteus_frames import (
    FAULTS,
    NODES,
    REPLY_WANTED,
    Form,
    Register,
    Replies,
    padded,
    parse,
    read,
)
from echogrid.drivers.readings import WheelReading
from echogrid.drivers.role import WheelRole
from echogrid.drivers.uptime import Uptime
from echogrid.drivers.wheel_angle import WheelAngle

QUERY = padded(
    (
        read(Form.INT8, Register.MODE),
        # As the firmware has them (motor_position.h): integers are made of these, and end at 21474 turns.
        read(Form.FLOAT, Register.POSITION, 2),
        read(Form.INT8, Register.VOLTAGE, 3),
        read(Form.INT8, Register.ENCODER_VALIDITY),
        read(Form.INT32, Register.MILLISECOND_COUNTER),
    )
)
WITHIN_NS = 50_000_000
"""For so long a reply is waited for."""
AGAIN_NS = 300_000_000
"""From a request without a reply to the next one: a late reply can't be taken for another's."""
GAP_NS = 300_000_000
"""In a longer silence it may have restarted, if it has no counter that would tell."""
STAMP_ERROR_NS = 1_000_000
"""It answers within the time of a frame, and a full bus holds it back for about two others."""
IN_FAULT = 1
"""The mode."""
LISTENS_IN_VAIN = (
    "a moteus says nothing unless it is asked, which listen_only = true at its bus forbids: leave that out, "
    "or put it on another bus"
)


class Moteus:
    """One controller, which is asked and never told anything: no frame to it writes a register."""

    bus: ClassVar[str] = "can"
    line: ClassVar[type[Line[CanFrame, CanFrame]]] = Line
    identity: ClassVar[str] = "node"
    port_options: ClassVar[Mapping[str, object]] = {"bitrate": 1_000_000, "fd": True}

    @dataclass(frozen=True, slots=True)
    class Settings:
        """Its keys in a config file."""

        node: int = 1
        """`id.id` of the controller."""
        prefix: int = 0
        """`can.prefix`: the identifier's bits above the sixteen."""
        poll_ms: int = 20
        """From request to request."""
        source: int = 0
        """Which of `motor_position.sources` its position comes from: `motor_position.output.source`."""
        hottest_c: float = 70.0
        """Warmer than that it is told as hot; from the factory it stops at 75 C."""

        def __post_init__(self) -> None:
            require_between("node", self.node, 1, NODES)
            require_between("prefix", self.prefix, 0, 0x1FFF)
            require_between("poll_ms", self.poll_ms, 2, 200)
            require_between("source", self.source, 0, 2)
            require_between("hottest_c", self.hottest_c, 0.0, 127.0)

    def __init__(self, role: WheelRole, settings: Settings) -> None:
        """Raises ValueError if it may not be asked."""
        if role.listen_only:
            raise ValueError(LISTENS_IN_VAIN)
        self.name = role.name
        self._settings = settings
        self._reply = settings.prefix << 16 | settings.node << 8
        identifier = settings.prefix << 16 | REPLY_WANTED | settings.node
        self._query = CanFrame(identifier, QUERY, extended=True, fd=True)
        self._angle = WheelAngle(role.gear, role.fastest, role.steering)
        self._uptime = Uptime()
        self._counts: Counter[str] = Counter()
        self._due_ns = 0
        self._asked_ns: int | None = None
        self._told: tuple[int, Replies] | None = None
        self._believed_ns: int | None = None
        self._late_ns: int | None = None
        self._garbled_ns: int | None = None
        self._gap = self._restarted = False

    def step(self, now_ns: int, received: Sequence[CanFrame]) -> Step[CanFrame]:
        """Take its replies in the order in which they came, and ask when it is time."""
        readings: list[WheelReading] = []
        for frame in received:
            if self._own(frame):
                readings += self._take(frame.stamp_ns or now_ns, frame.data)
        if self._asked_ns is not None and now_ns >= self._asked_ns + WITHIN_NS:
            self._counts["missing replies"] += 1
            self._due_ns = self._asked_ns + AGAIN_NS
            self._asked_ns = None
        send = () if self._asked_ns is not None or now_ns < self._due_ns else (self._ask(now_ns),)
        deadline_ns = self._due_ns if self._asked_ns is None else self._asked_ns + WITHIN_NS
        return Step(tuple(readings), send, deadline_ns)

    def lost(self, now_ns: int) -> None:
        """The port was lost: what was heard counts no more, and without its counter it may have restarted."""
        self._told = self._asked_ns = self._late_ns = self._garbled_ns = None
        self._due_ns = now_ns
        self._gap = True

    def health(self, now_ns: int) -> Health:
        """How it is."""
        state, message = self._condition(now_ns)
        return Health(state, message, dict(self._counts))

    def _condition(self, now_ns: int) -> tuple[State, str]:
        told = self._told  # its bus's thread may lose the port at any time
        if told is None or is_old(told[0], now_ns):
            return self._speechless(now_ns)
        replies = told[1]
        if replies.number(Register.MODE) == IN_FAULT:
            code = replies.number(Register.FAULT) or 0
            name, volts = FAULTS.get(code, "fault"), replies.quantity(Register.VOLTAGE)
            return State.FAILED, f"{name} ({code}, supply {volts:.1f} V): mend that, then clear it by a stop"
        if is_old(self._believed_ns, now_ns):
            return State.FAULTY, self._unbelieved(replies)
        celsius = replies.quantity(Register.TEMPERATURE)
        if celsius > self._settings.hottest_c:
            return (
                State.HOT,
                f"board at {celsius:.0f} C: it gives less current soon; let it cool, load it less",
            )
        return State.WELL, "turning counted"

    def _speechless(self, now_ns: int) -> tuple[State, str]:
        """Why there is no reply that can be used."""
        node = self._settings.node
        if not is_old(self._garbled_ns, now_ns):
            return (
                State.GARBLED,
                f"what comes with the identifier {self._reply:#x} is no reply of a moteus: has another "
                "device that identifier?",
            )
        if not is_old(self._late_ns, now_ns):
            return (
                State.STALLED,
                f"moteus {node} is heard {WITHIN_NS // 1_000_000} ms after it was asked or later, or "
                "unasked: is the bus or the machine too busy, or does another program ask it?",
            )
        return (
            State.MISSING,
            f"no reply from moteus {node}: check its power, wires, id and prefix, and that the bus has "
            "CAN-FD at 1 and 5 Mbit/s with its sample points at 0.666",
        )

    def _unbelieved(self, replies: Replies) -> str:
        """Why its positions are none."""
        if not self._located(replies):
            return (
                "it has no position: check the encoder of source "
                f"{self._settings.source} (motor_position.sources), and whether that is the output's"
            )
        return (
            "its position jumps further than the wheel can turn, or is no number: are gear and fastest_rad_s "
            f"right, and is there one moteus {self._settings.node} only?"
        )

    def _own(self, frame: CanFrame) -> bool:
        """Whether it is a frame of this controller to us; any other is counted."""
        if not frame.fd:
            self._counts["classic frames"] += 1
        elif frame.identifier != self._reply:
            self._counts["foreign frames"] += 1
        else:
            return True
        return False

    def _ask(self, now_ns: int) -> CanFrame:
        """The request. After a stall it goes on from now."""
        period_ns = self._settings.poll_ms * 1_000_000
        self._due_ns += period_ns * (max(now_ns - self._due_ns, 0) // period_ns + 1)
        self._asked_ns = now_ns
        self._counts["requests"] += 1
        return self._query

    def _take(self, stamp_ns: int, data: bytes) -> tuple[WheelReading, ...]:
        replies = parse(data)
        if not replies.whole:
            self._counts["malformed replies"] += 1
            self._garbled_ns = stamp_ns
            return ()
        if self._asked_ns is None:
            self._counts["unasked replies"] += 1
            self._late_ns = stamp_ns
            return ()
        if not self._complete(replies):
            self._counts["replies to others"] += 1
            return ()
        self._asked_ns = None
        self._counts["replies"] += 1
        self._watch(stamp_ns, replies.number(Register.MILLISECOND_COUNTER))
        self._told = stamp_ns, replies
        return self._position(stamp_ns, replies, data)

    def _complete(self, replies: Replies) -> bool:
        """Whether it answers our request, and not one of somebody else who has our identifier."""
        position = replies.values.get(Register.POSITION)
        asked = (Register.MODE, Register.VELOCITY, Register.FAULT)
        whole = all(register in replies.values for register in asked)
        return whole and position is not None and position.form is Form.FLOAT

    def _watch(self, stamp_ns: int, milliseconds: int | None) -> None:
        """See whether it has restarted since its last reply; older firmware has no counter."""
        if milliseconds is not None:
            self._restarted |= self._uptime.restarted(stamp_ns, milliseconds)
            self._gap = False
        elif self._told is not None:
            self._gap |= stamp_ns - self._told[0] > GAP_NS

    def _located(self, replies: Replies) -> bool:
        """Whether it knows where it is. Angle and velocity of each source have a bit of the validity."""
        validity = replies.number(Register.ENCODER_VALIDITY)
        known = validity is None or validity >> 2 * self._settings.source & 3 != 0
        return known and isfinite(replies.quantity(Register.POSITION))

    def _position(self, stamp_ns: int, replies: Replies, raw: bytes) -> tuple[WheelReading, ...]:
        if not self._located(replies):
            self._counts["replies without a position"] += 1
            self._restarted = True  # it may have lost turns
            return ()
        turns, rate = replies.quantity(Register.POSITION), replies.quantity(Register.VELOCITY)
        if reason := self._doubt(stamp_ns, turns, rate):
            self._counts[reason] += 1
            return ()
        advance = self._angle.advance(stamp_ns, turns, rate, restarted=self._gap or self._restarted)
        if advance is None:
            self._counts["doubtful jumps"] += 1
            return ()
        angle, jumped = advance
        self._gap = self._restarted = False
        self._believed_ns = stamp_ns
        self._counts["readings"] += 1
        self._counts["discontinuities"] += jumped
        wheel_rate = self._angle.rate(rate)
        return (WheelReading(stamp_ns, STAMP_ERROR_NS, self.name, angle, wheel_rate, jumped, raw),)

    def _doubt(self, stamp_ns: int, turns: float, rate: float) -> str:
        """Why a position is not believed; empty if it is."""
        if not (isfinite(rate) and self._angle.believable(turns, rate)):
            return "positions out of range"
        if not self._angle.precedes(stamp_ns):
            return "positions out of order"
        return ""
