"""One channel of a Roboteq motor controller: its absolute counter, asked for or sent in a variable."""

from collections.abc import Mapping, Sequence
from struct import Struct
from typing import ClassVar

from echogrid.drivers import canopen
from echogrid.drivers.bus import CanFrame
from echogrid.drivers.canopen import NmtState
from echogrid.drivers.counter import CountedWheel, Scale
from echogrid.drivers.device import Health, Line, State, Step
from echogrid.drivers.freshness import is_old
from echogrid.drivers.readings import WheelReading
from echogrid.drivers.roboteq_flags import FAULT_FLAGS, OVERHEAT, STATUS_FLAGS, Flags, fault_report
from echogrid.drivers.roboteq_poll import LATE_NS, Poll
from echogrid.drivers.roboteq_settings import CHANNELS, RoboteqSettings
from echogrid.drivers.role import WheelRole
from echogrid.drivers.sdo import SdoAnswer, SdoRead, object_name

COUNTER_BITS = 32
FLAGS_NS = 1_000_000_000
"""From request to request for the flags."""
COUNT_NS = 500_000_000
"""So old a count may be."""
MISSED = 4
"""So many heartbeats that stay away are told."""
LISTEN_ONLY = (
    'its counter must be asked for, and its bus has listen_only = true: set source = "variable", and let a '
    "script on the controller copy the counter into a variable (docs/devices/roboteq.md)"
)

_ON_ITS_WAY = (NmtState.BOOT, NmtState.OPERATIONAL)
_COUNT = Struct("<i")
_VARIABLES = Struct("<ii")


def decode_variables(data: bytes) -> tuple[int, int]:
    """The two variables in the 8 bytes of a TPDO."""
    first, second = _VARIABLES.unpack(data)
    return first, second


class Roboteq:
    """Reads absolute counters, and sends nothing but requests to read; with "variable" nothing at all."""

    bus: ClassVar[str] = "can"
    line: ClassVar[type[Line[CanFrame, CanFrame]]] = Line
    identity: ClassVar[str] = "counter"
    port_options: ClassVar[Mapping[str, object]] = {"bitrate": 125_000}
    Settings = RoboteqSettings

    def __init__(self, role: WheelRole, settings: RoboteqSettings) -> None:
        """Raises ValueError if its bus may only be listened to and its counter must be asked for."""
        if role.listen_only and settings.source == "sdo":
            raise ValueError(LISTEN_ONLY)
        self.name = role.name
        self._settings = settings
        self._wheel = CountedWheel(role, Scale(1 << COUNTER_BITS, settings.counts_per_turn))
        self._counts = self._wheel.counts
        self._poll = self._polling() if settings.source == "sdo" else None
        self._parts = _parts(settings)
        self._beats_ns = MISSED * settings.heartbeat_ms * 1_000_000
        self._flags = Flags()
        self._forget()

    def step(self, now_ns: int, received: Sequence[CanFrame]) -> Step[CanFrame]:
        """Take the controller's own frames in the order in which they came, and ask for its counter."""
        readings: list[WheelReading] = []
        for frame in received:
            if part := self._part(frame):
                readings += self._take(part, frame.stamp_ns or now_ns, frame.data)
        if self._poll is None:
            return Step(tuple(readings))
        if not self._there(now_ns):
            self._poll.forget()
            return Step(tuple(readings))
        send = self._poll.step(now_ns)
        return Step(tuple(readings), send, self._poll.deadline_ns)

    def lost(self, now_ns: int) -> None:  # noqa: ARG002 - as every device is told
        """The port was lost: what was heard counts no more, and the controller may have restarted."""
        self._forget()
        self._wheel.lost()
        if self._poll is not None:
            self._poll.forget()

    def health(self, now_ns: int) -> Health:
        """How it is."""
        state, message = self._condition(now_ns)
        return Health(state, message, dict(self._counts))

    def _polling(self) -> Poll:
        interval_ns = self._settings.poll_ms * 1_000_000
        intervals_ns = {self._settings.read: interval_ns, STATUS_FLAGS: FLAGS_NS, FAULT_FLAGS: FLAGS_NS}
        # The channels of a controller are asked one after the other.
        phase_ns = (self._settings.channel - 1) * interval_ns // CHANNELS
        return Poll(self._settings.node, intervals_ns, phase_ns, self._counts)

    def _there(self, now_ns: int) -> bool:
        """Whether to ask: an adapter repeats a request into an empty bus for ever."""
        return self._beats_ns == 0 or not self._silent(now_ns)

    def _forget(self) -> None:
        self._heard_ns: int | None = None
        self._beat: tuple[int, int] | None = None
        self._count_ns: int | None = None
        self._late_ns: int | None = None
        self._refusal = ""
        self._flags.forget()

    # What it says

    def _part(self, frame: CanFrame) -> str:
        """Which part of the controller has sent a well-formed frame; any other is counted."""
        name, length = self._parts.get(frame.identifier, ("", 0))
        if frame.extended or frame.remote:
            self._counts["extended or remote frames"] += 1
        elif not name:
            self._counts["foreign frames"] += 1
        elif len(frame.data) != length:
            self._counts[f"{name} frames of a wrong length"] += 1
        else:
            return name
        return ""

    def _take(self, part: str, stamp_ns: int, data: bytes) -> tuple[WheelReading, ...]:
        self._wheel.heard(stamp_ns)
        self._heard_ns = stamp_ns
        if part == "variable":
            return self._read(stamp_ns, decode_variables(data)[(self._settings.variable - 1) % 2], data)
        if part == "reply" and self._poll is not None:
            return self._replied(self._poll, stamp_ns, data)
        self._heartbeat(stamp_ns, canopen.decode_heartbeat(data))
        return ()

    def _heartbeat(self, stamp_ns: int, state: int) -> None:
        if state == NmtState.BOOT:
            self._counts["restarts"] += 1
            self._flags.forget()
            self._wheel.restarted()
            if self._poll is not None:
                self._poll.forget()
        self._beat = stamp_ns, state

    def _replied(self, poll: Poll, stamp_ns: int, data: bytes) -> tuple[WheelReading, ...]:
        answer = poll.take(data)
        if answer is None:
            return ()
        if stamp_ns - poll.asked_ns > LATE_NS:
            self._counts["late replies"] += 1
            self._late_ns = stamp_ns
        elif answer.request == self._settings.read:
            # It was counted at some time between the request and the reply.
            return self._counted((poll.asked_ns + stamp_ns) // 2, answer)
        elif isinstance(answer.request, SdoRead):
            self._flags.take(stamp_ns, answer.request, answer)
        return ()

    def _counted(self, stamp_ns: int, answer: SdoAnswer) -> tuple[WheelReading, ...]:
        self._refusal = answer.trouble
        if answer.trouble:
            self._counts["refusals"] += 1
            return ()
        if len(answer.data) != _COUNT.size:
            self._counts["counts of a wrong length"] += 1
            return ()
        (count,) = _COUNT.unpack(answer.data)
        return self._read(stamp_ns, count, answer.data)

    def _read(self, stamp_ns: int, count: int, raw: bytes) -> tuple[WheelReading, ...]:
        self._count_ns = stamp_ns
        return self._wheel.read(stamp_ns, count, raw)

    # How it is

    def _condition(self, now_ns: int) -> tuple[State, str]:
        if self._silent(now_ns):
            return State.SILENT, self._unheard()
        if self._refusal:
            return (
                State.WRONG_DEVICE,
                f"{self._refusal}: has it that channel, and that counter? Older firmware lacks some objects: "
                'update it, or set source = "variable"',
            )
        if is_old(self._count_ns, now_ns, COUNT_NS):
            return State.STALLED, self._missing(now_ns)
        if is_old(self._wheel.believed_ns, now_ns, COUNT_NS):
            return State.FAULTY, self._jumping()
        if faults := self._flags.faults(now_ns):
            return State.HOT if faults == OVERHEAT else State.FAILED, fault_report(faults)
        if self._beatless(now_ns):
            return (
                State.FAULTY,
                f"turning counted, but no heartbeat in {self._beats_ns // 1_000_000} ms, so that a restart "
                "may be missed: is heartbeat_ms that of the controller (CHB)?",
            )
        return State.WELL, "; ".join(("turning counted", *self._flags.remarks(now_ns)))

    def _silent(self, now_ns: int) -> bool:
        return is_old(self._heard_ns, now_ns, max(COUNT_NS, self._beats_ns))

    def _unheard(self) -> str:
        """What may be wrong if nothing comes."""
        settings = self._settings
        beats = ", and that it sends heartbeats (CHB), or set heartbeat_ms = 0" if self._beats_ns else ""
        return (
            f"nothing comes from node {settings.node}: check its power, wires, node id, bit rate and CAN mode"
            f"{beats if settings.source == 'sdo' else ''}"
        )

    def _missing(self, now_ns: int) -> str:
        """Why there are no counts."""
        settings, beat = self._settings, self._beat
        state = canopen.state_name(beat[1]) if beat and beat[1] not in _ON_ITS_WAY else ""
        if settings.source == "variable":
            if state:
                return f"it is {state}, and sends no TPDO: set its autostart, or let its master start it"
            return (
                f"heartbeats, but no TPDO{settings.tpdo}, which has VAR{settings.variable}: give it a send "
                f"rate (CTPS {settings.tpdo}; in MiniCAN SendRate)"
            )
        if not is_old(self._late_ns, now_ns, COUNT_NS):
            return f"its replies come more than {LATE_NS // 1_000_000} ms late: is its bus full?"
        asked = f"no reply to the request for {object_name(settings.read)}"
        if state:
            return f"{asked}: it is {state}"
        return f'{asked}: is its CAN mode CANopen? In MiniCAN nothing can be asked for: source = "variable"'

    def _jumping(self) -> str:
        written = "the counter" if self._settings.source == "sdo" else "the counter or the variable"
        few = " In MiniCAN only VAR1 to VAR4 have 32 bits." if self._settings.tpdo > 2 else ""
        return (
            "its counter jumps further than the wheel can turn: are counts_per_turn, gear and fastest_rad_s "
            f"right, is there one node {self._settings.node} only, does nothing else write {written}?{few}"
        )

    def _beatless(self, now_ns: int) -> bool:
        """Whether it should send heartbeats, and does not."""
        beat = self._beat  # its bus's thread may lose the port at any time
        return self._beats_ns > 0 and is_old(beat[0] if beat else None, now_ns, self._beats_ns)


def _parts(settings: RoboteqSettings) -> dict[int, tuple[str, int]]:
    """What is listened to, by identifier, and how many bytes that has."""
    node = settings.node
    counts = {
        "sdo": (canopen.SDO_REPLY + node, "reply"),
        "variable": (canopen.tpdo(settings.tpdo, node), "variable"),
    }
    identifier, name = counts[settings.source]
    return {canopen.HEARTBEAT + node: ("heartbeat", 1), identifier: (name, canopen.LENGTH)}
