"""The messages that let a drive (CiA 402) turn at a rate, in profile velocity mode."""

from collections.abc import Sequence
from math import tau
from struct import Struct

from echogrid.drivers import canopen, canopen_pdo
from echogrid.drivers.bus import CanFrame
from echogrid.drivers.canopen import mapping
from echogrid.drivers.canopen_pdo import Pdo
from echogrid.drivers.cia402_settings import COUNTER_BITS, Cia402Settings
from echogrid.drivers.cia402_state import DriveState
from echogrid.drivers.limits import clipped
from echogrid.drivers.sdo import SdoWrite
from echogrid.drivers.sdo_course import SdoCourse, SdoPilot, do_all
from echogrid.drivers.ticker import Ticker

CONTROL = mapping(0x6040, 0, 16)
TARGET_VELOCITY = mapping(0x60FF, 0, 32)
STAND = SdoWrite(0x60FF, 0, bytes(4))
"""A drive that is enabled already turns at its old target as soon as the mode is set."""
MODE = SdoWrite(0x6060, 0, b"\x03")
"""Profile velocity."""
STOP_WITHOUT_MASTER = SdoWrite(0x6007, 0, b"\x03\x00")
"""Abort connection option code: quick stop."""
CONSUMER_TIME = 0x1016
MASTER_LOST_MS = 500
BEAT_NS = 100_000_000

DISABLE_VOLTAGE, QUICK_STOP, SHUTDOWN, SWITCH_ON, ENABLE = 0x00, 0x02, 0x06, 0x07, 0x0F
"""Control words."""
NEXT = {
    DriveState.SWITCH_ON_DISABLED: SHUTDOWN,
    DriveState.READY: SWITCH_ON,
    DriveState.SWITCHED_ON: ENABLE,
    DriveState.QUICK_STOP: DISABLE_VOLTAGE,
}
"""What brings it nearer to operation enabled. No fault is reset."""

_COMMAND = Struct("<Hi")
_MOST = float((1 << COUNTER_BITS - 1) - 1)


class VelocityCommands:
    """Prepares a drive by SDO and leads it to operation enabled; our heartbeat tells it that we live."""

    def __init__(self, settings: Cia402Settings, gear: float) -> None:
        self.state: DriveState | None = None
        """What the drive says."""
        self._settings = settings
        self._units_per_radian = settings.units_per_turn * gear / tau
        self._pilot = SdoPilot[str](settings.node)
        self._beat = Ticker(BEAT_NS)
        self._begun = self._guarded = False

    @property
    def prepared(self) -> bool:
        """Whether it takes our rates."""
        return self._pilot.outcome == ""

    @property
    def trouble(self) -> str:
        """Why it can't be prepared; empty if nothing is known against it."""
        return self._pilot.outcome or ""

    @property
    def deadline_ns(self) -> int:
        """When to step again."""
        return min(self._pilot.deadline_ns, self._beat.deadline_ns)

    def take(self, data: bytes) -> bool:
        """Take a reply to SDO; whether it was waited for."""
        return self._pilot.take(data)

    def step(self, now_ns: int) -> tuple[CanFrame, ...]:
        """What prepares it, and our heartbeat."""
        if self._begun:
            self._beat.start(now_ns)
        beat = (canopen.heartbeat(self._settings.master),) if self._beat.due(now_ns) else ()
        return (*beat, *self._pilot.step(now_ns))

    def enable(self) -> Sequence[CanFrame]:
        """Prepare it at first, then one control word after the other, as its state asks for."""
        if not self._begun:
            self._begun = True
            self._pilot.start(self._prepare())
        word = NEXT.get(self.state) if self.state else None
        return () if word is None or not self.prepared else (self._command(word, 0),)

    def drive(self, rate: float) -> Sequence[CanFrame]:
        """Turn the wheel at that rate, rad/s."""
        return (self._command(ENABLE, round(clipped(rate * self._units_per_radian, _MOST))),)

    def let_go(self) -> Sequence[CanFrame]:
        """Stop on its quick stop ramp; disabling it at once would cut that. Then our heartbeat may end."""
        send: list[CanFrame] = []
        if self.prepared:
            send.append(self._command(QUICK_STOP, 0))
        if self._guarded:
            unguard = self._consumer(0)
            send.append(canopen.write_request(self._settings.node, unguard.index, unguard.sub, unguard.value))
        self.forget()
        return send

    def forget(self) -> None:
        """It may know nothing any more, or can't be told."""
        self._pilot.stop()
        self._beat.stop()
        self._begun = self._guarded = False

    def _prepare(self) -> SdoCourse[str]:
        settings = self._settings
        pdo = Pdo(settings.rpdo, (CONTROL, TARGET_VELOCITY))
        trouble = yield from do_all((*canopen_pdo.receive(settings.node, pdo), STAND, MODE))
        if trouble:
            return trouble
        guard = yield self._consumer(MASTER_LOST_MS)
        self._guarded = not guard.trouble
        reaction = yield STOP_WITHOUT_MASTER
        unguarded = guard.trouble or reaction.trouble
        return f"{unguarded}: it would not stop by itself if we were gone" if unguarded else ""

    def _consumer(self, within_ms: int) -> SdoWrite:
        """Of our heartbeat: without it for so long, it reacts; 0: never."""
        entry = self._settings.master << 16 | within_ms if within_ms else 0
        return SdoWrite(CONSUMER_TIME, 1, entry.to_bytes(4, "little"))

    def _command(self, word: int, units: int) -> CanFrame:
        identifier = canopen.rpdo(self._settings.rpdo, self._settings.node)
        return CanFrame(identifier, _COMMAND.pack(word, units))
