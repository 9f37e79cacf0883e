"""JSN-SR04T (mode 3), AJ-SR04M (mode 4) and kin: one byte makes them ping, an FF H L SUM frame answers."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from errno import ETIMEDOUT
from typing import ClassVar

from echogrid.drivers.bus import Result, SerialTransfer
from echogrid.drivers.commanded import CommandedRanger
from echogrid.drivers.conversation import BITS_PER_BYTE, Conversation
from echogrid.drivers.course import Course
from echogrid.drivers.device import State
from echogrid.drivers.ff_frame import LENGTH, LONGEST_MM, decode
from echogrid.drivers.ff_parts import PARTS, PartName, PartSettings
from echogrid.drivers.limits import require_between
from echogrid.drivers.make import MILLISECOND_NS, Answer, Fired, Make, Trouble
from echogrid.drivers.readings import Outcome
from echogrid.drivers.role import RangerRole
from echogrid.drivers.serial_talk import SILENCE, answered, ask, exactly, unanswered

PING_NS = 65 * MILLISECOND_NS
"""The data sheet's 60 ms without an echo, and the frame."""
REST_NS = 60 * MILLISECOND_NS
"""It is busy for so long, and so are the echoes in the room."""


class FfOnDemandMake(Make[SerialTransfer]):
    """The trigger and the frame. It can't be asked anything without a ping, so that is how it is set up."""

    where = "the ranger"
    idle = SILENCE
    ping_ns = PING_NS
    rest_ns = REST_NS
    patience_ns = 0

    def __init__(self, role: RangerRole, settings: "FfOnDemand.Settings") -> None:
        self._slot = role.slot
        self._baud = settings.baud
        self._byte_ns = BITS_PER_BYTE * 1_000_000_000 // settings.baud
        self._trigger = bytes((settings.byte,))
        self._within_ns = round(settings.wait_ms * 1e6)
        self._silent_ns = round(settings.silent_s * 1e9)
        self._codes = settings.chosen.codes
        self._header_summed = settings.chosen.header_summed
        self._garbled = settings.garbled()
        self._replied_ns = 0

    def set_up(self) -> Course[SerialTransfer, Trouble | None]:
        """Ping in a turn of its own, whose distance nobody gets, and look whether a frame answers."""
        now_ns = (yield SILENCE).end_ns
        if self._slot is not None:
            yield self._slot.next_turn(now_ns).start_ns
        result = yield from self._ask()
        if result.errno:
            return unanswered(self.where, result, self._baud)
        if self._distance_mm(result.data) is None:
            return Trouble(State.GARBLED, self._no_frame(result.data))
        yield result.end_ns + REST_NS
        return None

    def fire(self, listens: bool) -> Course[SerialTransfer, Fired]:
        """Ping; it can't listen without."""
        del listens
        result = yield from self._ask()
        ping = answered(result, self._byte_ns)
        if result.errno != ETIMEDOUT:
            return replace(ping, state=State.GARBLED)
        silent = result.end_ns - self._replied_ns <= self._silent_ns
        return replace(ping, trouble="", silent=True) if silent else ping

    def collect(self) -> Course[SerialTransfer, bytes]:
        """Nothing: the answer came as the reply."""
        yield SILENCE
        return b""

    def answer(self, data: bytes) -> Answer:
        """What the frame means."""
        millimetres = self._distance_mm(data)
        if millimetres is None:
            return Answer(doubt=self._no_frame(data), state=State.GARBLED)
        outcome, reason = self._codes.get(millimetres, (Outcome.ECHO, ""))
        if reason:
            return Answer(doubt=reason, gone=False)
        return Answer((millimetres / 1000,) if outcome is Outcome.ECHO else ())

    def _ask(self) -> Course[SerialTransfer, Result[SerialTransfer]]:
        result = yield from ask(self._trigger, exactly(LENGTH), self._within_ns)
        if not result.errno:
            self._replied_ns = result.end_ns
        return result

    def _distance_mm(self, data: bytes) -> int | None:
        """The frame's value, a distance or a code; None if it is not a frame."""
        millimetres = decode(data, self._header_summed)
        if millimetres is None or (millimetres > LONGEST_MM and millimetres not in self._codes):
            return None
        return millimetres

    def _no_frame(self, data: bytes) -> str:
        return f"a reply that is no frame ({data.hex(' ')}): {self._garbled}"


class FfOnDemand(CommandedRanger[SerialTransfer]):
    """One ranger, alone on its line."""

    bus: ClassVar[str] = "serial"
    line: ClassVar[type[Conversation]] = Conversation
    identity: ClassVar[str] = ""

    @dataclass(frozen=True, slots=True)
    class Settings(PartSettings):
        """Its keys in a config file."""

        part: PartName = "jsn-sr04t"
        trigger: int | None = None
        """The byte at which it pings; None: as the part has it."""
        wait_ms: float = 120.0
        """How long the frame is waited for."""
        silent_s: float = 0.0
        """Some say nothing when they hear nothing. For so long after its last frame silence means no echo,
        and then that it is missing; 0: at once."""

        def __post_init__(self) -> None:
            PartSettings.__post_init__(self)
            require_between("trigger", self.byte, 0, 0xFF)
            require_between("wait_ms", self.wait_ms, 1.0, 2000.0)
            require_between("silent_s", self.silent_s, 0.0, 3600.0)

        @property
        def byte(self) -> int:
            """The byte at which it pings."""
            return PARTS[self.part].trigger if self.trigger is None else self.trigger

    def __init__(self, role: RangerRole, settings: Settings) -> None:
        """Raises ValueError if more is asked for than the part reaches."""
        require_between("max_m", role.farthest, 0.0, settings.chosen.reach_m)
        super().__init__(role, FfOnDemandMake(role, settings))
        self.port_options: Mapping[str, object] = {"baud": settings.baud}
