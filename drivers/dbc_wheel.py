"""Any controller that sends its position unasked in a frame which a DBC file describes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import isfinite, tau
from typing import ClassVar, Literal

from echogrid.drivers.bus import CanFrame
from echogrid.drivers.counter import CountedWheel, Scale, difference
from echogrid.drivers.dbc import Signal, load_signals
from echogrid.drivers.device import Health, Line, State, Step
from echogrid.drivers.freshness import is_old
from echogrid.drivers.limits import require_between
from echogrid.drivers.readings import WheelReading
from echogrid.drivers.role import WheelRole

STEPS_PER_TURN = 1 << 24
"""A position that is a float is counted in such steps: finer than float32 is after one turn."""
FLOAT_BITS = 64
MOST_TURNS = 2.0 ** (FLOAT_BITS - 1 - 24)


@dataclass(frozen=True, slots=True)
class DbcSettings:
    """Its keys in a config file."""

    file: str
    """The DBC file: an absolute path, or one from the working directory."""
    position: str
    """The position's message and signal, "Message.Signal"."""
    unit: Literal["counts", "turns", "rad"]
    """What the position is in, after the file's own factor and `scale`."""
    counts_per_turn: float = 0.0
    """Of the encoder, with `unit = "counts"`."""
    width: int = 0
    """Bits after which the position wraps; 0: those of its signal. A float does not wrap."""
    scale: float = 1.0
    """By which the position is multiplied, after the file's own factor."""
    velocity: str = ""
    """The velocity's message and signal; without it, it is the mean since the position before."""
    velocity_scale: float = 1.0
    """By which the velocity is multiplied, to be in `unit` per second."""
    velocity_signed: bool | None = None
    """Whether the velocity has a sign, where the file says it wrong."""

    def __post_init__(self) -> None:
        require_between("width", self.width, 0, 64)
        for key, scale in (("scale", self.scale), ("velocity_scale", self.velocity_scale)):
            if not 1e-12 <= abs(scale) <= 1e12:
                raise ValueError(f"{key} is {scale}: expected 1e-12 to 1e12, or below 0 as far")
        if self.unit == "counts":
            require_between("counts_per_turn", self.counts_per_turn, 1e-3, 1e9)
        elif self.counts_per_turn:
            raise ValueError(f'counts_per_turn is {self.counts_per_turn}, but unit is "{self.unit}"')
        for key, name in (("position", self.position), ("velocity", self.velocity)):
            if name.count(".") != 1 and (name or key == "position"):
                raise ValueError(f'{key} is {name!r}: expected "Message.Signal"')

    @property
    def units_per_turn(self) -> float:
        """How many of `unit` make a turn of the encoder."""
        return {"counts": self.counts_per_turn, "turns": 1.0, "rad": tau}[self.unit]


class Position:
    """A signal's position as counts: those which it has, or fine steps of a float."""

    def __init__(self, signal: Signal, settings: DbcSettings) -> None:
        """Raises ValueError if it is narrower than `width`."""
        self._signal = signal
        self._turns_per_unit = settings.scale / settings.units_per_turn
        turns_per_step = signal.factor * self._turns_per_unit
        if not signal.floating and not 1e-12 <= abs(turns_per_step) <= 1e3:
            raise ValueError(
                f"a step of {settings.position} is {turns_per_step:.3g} turns: is its scale right?"
            )
        if signal.floating and settings.width:
            raise ValueError(
                f"width is {settings.width}, but {settings.position} is a float, which does not wrap"
            )
        if settings.width > signal.bits:
            raise ValueError(f"width is {settings.width}: {settings.position} has {signal.bits} bits")
        self._zero = 0 if signal.floating else round(signal.offset / signal.factor)
        modulus = 1 << (FLOAT_BITS if signal.floating else settings.width or signal.bits)
        self.scale = Scale(modulus, STEPS_PER_TURN if signal.floating else 1.0 / abs(turns_per_step))
        self.backwards = not signal.floating and turns_per_step < 0

    def count(self, data: bytes) -> int | None:
        """The count in a frame, None if it is no number.

        A counter's is taken on the shortest way from zero: what the file says of its sign does not matter.
        """
        if not self._signal.floating:
            return difference(int(self._signal.raw(data)) + self._zero, 0, self.scale.modulus)
        turns = self._signal.value(data) * self._turns_per_unit
        return round(turns * STEPS_PER_TURN) if isfinite(turns) and abs(turns) < MOST_TURNS else None


class DbcWheel:
    """One controller that is only listened to."""

    bus: ClassVar[str] = "can"
    line: ClassVar[type[Line[CanFrame, CanFrame]]] = Line
    identity: ClassVar[str] = "position"
    port_options: ClassVar[Mapping[str, object]] = {"bitrate": 250_000}
    Settings = DbcSettings

    def __init__(self, role: WheelRole, settings: DbcSettings) -> None:
        """Reads the file. Raises ValueError if that or a signal of it can't be used."""
        self.name = role.name
        self._settings = settings
        names = (settings.position, settings.velocity) if settings.velocity else (settings.position,)
        signals = load_signals(settings.file, names)
        self._position_signal = signals[0]
        self._velocity_signal = signals[1].with_sign(settings.velocity_signed) if signals[1:] else None
        self._own = {(signal.identifier, signal.extended): signal.length for signal in signals}
        self._position = Position(signals[0], settings)
        direction = -1.0 if self._position.backwards else 1.0
        self._turns_per_velocity = direction * settings.velocity_scale / settings.units_per_turn
        self._wheel = CountedWheel(replace(role, gear=direction * role.gear), self._position.scale)
        self._counts = self._wheel.counts
        self._heard_ns: int | None = None
        self._short_ns: int | None = None
        self._velocity: tuple[int, float] | None = None

    def step(self, now_ns: int, received: Sequence[CanFrame]) -> Step[CanFrame]:
        """Take the frames with its signals in the order in which they came."""
        readings: list[WheelReading] = []
        for frame in received:
            length = self._own.get((frame.identifier, frame.extended))
            if length is None or frame.remote:
                self._counts["other frames"] += 1
            elif len(frame.data) < length:
                self._counts["short frames"] += 1
                self._short_ns = frame.stamp_ns or now_ns
            else:
                readings += self._take(frame, frame.stamp_ns or now_ns)
        return Step(tuple(readings))

    def lost(self, now_ns: int) -> None:  # noqa: ARG002 - as every device is told
        """The port was lost: what was heard counts no more, and the controller may have restarted."""
        self._heard_ns = self._short_ns = self._velocity = None
        self._wheel.lost()

    def health(self, now_ns: int) -> Health:
        """How it is."""
        state, message = self._condition(now_ns)
        return Health(state, message, dict(self._counts))

    def _condition(self, now_ns: int) -> tuple[State, str]:
        name, signal = self._settings.position, self._position_signal
        if not is_old(self._short_ns, now_ns) and is_old(self._heard_ns, now_ns):
            return (
                State.WRONG_DEVICE,
                f"its frames are shorter than {signal.length} bytes: is the DBC file its own?",
            )
        if is_old(self._heard_ns, now_ns):
            return (
                State.SILENT,
                f"no frame {signal.identifier:#x} ({name}): check power, wires, bit rate, and that it sends",
            )
        if is_old(self._wheel.believed_ns, now_ns):
            return (
                State.FAULTY,
                f"{name} is no number, or jumps further than the wheel can turn: are width, scale, "
                "counts_per_turn, gear and fastest_rad_s right?",
            )
        return State.WELL, "turning counted"

    def _take(self, frame: CanFrame, stamp_ns: int) -> tuple[WheelReading, ...]:
        """Read whichever of the signals it has."""
        if self._velocity_signal is not None and _in(frame, self._velocity_signal):
            rate = self._velocity_signal.value(frame.data) * self._turns_per_velocity
            self._velocity = stamp_ns, rate
        if not _in(frame, self._position_signal):
            return ()
        self._heard_ns = stamp_ns
        self._wheel.heard(stamp_ns)
        count = self._position.count(frame.data)
        if count is None:
            self._counts["no numbers"] += 1
            return ()
        return self._wheel.read(stamp_ns, count, frame.data, self._rate(stamp_ns))

    def _rate(self, now_ns: int) -> float | None:
        """Turns/s of the encoder, if they are told."""
        velocity = self._velocity
        return None if velocity is None or is_old(velocity[0], now_ns) else velocity[1]


def _in(frame: CanFrame, signal: Signal) -> bool:
    return (frame.identifier, frame.extended) == (signal.identifier, signal.extended)
