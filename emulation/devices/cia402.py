"""An emulated drive after CiA 402: an encoder, and a motor in profile velocity mode."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import floor, tau
from random import Random

from echogrid.drivers.bus import NEVER_NS
from echogrid.emulation.devices.canopen_node import CanopenNode
from echogrid.emulation.devices.canopen_objects import INVALID_VALUE, AbortError, Item, Key
from echogrid.emulation.devices.cia402_states import (
    OPERATION_ENABLED,
    QUICK_STOP_ACTIVE,
    SWITCH_ON_DISABLED,
    StateMachine,
)
from echogrid.emulation.devices.shaft import Shaft
from echogrid.emulation.faults import Verb

_DEVICE_TYPE = 0x0002_0192
"""A servo drive of profile 402."""
_CONTROL, _STATUS, _POSITION, _VELOCITY = (0x6040, 0), (0x6041, 0), (0x6064, 0), (0x606C, 0)
_TARGET = (0x60FF, 0)
_PROFILE_VELOCITY = 3
_MODES = (0, _PROFILE_VELOCITY)
_QUICK_STOP = 3
"""Of 6007h."""
_QUICK_STOP_NS = 500_000_000
"""It stands after so long, and is switched off: a guess."""
_SLOPE_NS = 5_000_000
"""The velocity is the mean over so long."""
_OVER_CURRENT, _ENCODER = 0x2310, 0x7305
_REGISTERS = {_OVER_CURRENT: 0x03, _ENCODER: 0x21}
"""Generic, with current or with the profile's own."""


@dataclass(frozen=True, slots=True)
class Cia402Options:
    """How the drive is configured."""

    node: int = 1
    gear: float = 1.0
    """Turns of the motor for one of the wheel; negative if it counts backwards."""
    counts_per_turn: float = 4096
    velocity_units: float = 0.0
    """For one turn a second; 0: counts per second."""
    range_counts: int = 0
    """The position wraps after so many, at half of that; 0: at 2^31."""
    origin: int = 0
    """What the position begins with; a real one begins with 0."""

    def __post_init__(self) -> None:
        if not 1 <= self.node <= 127:
            raise ValueError(f"node {self.node} is no CANopen node (1 to 127)")
        if self.counts_per_turn < 1:
            raise ValueError(f"counts_per_turn {self.counts_per_turn}: an encoder has at least one")


class Cia402Drive(CanopenNode):
    """Pre-operational after power-up, and silent but for its boot-up message until it is set up."""

    def __init__(
        self,
        name: str,
        angle: Callable[[int], float],
        random: Random,
        options: Cia402Options = Cia402Options(),
    ) -> None:
        self._machine = StateMachine()
        self._stood_ns = NEVER_NS
        self._shaft = Shaft.of(angle)
        self._options = options
        self._zero = 0.0
        self._frozen: int | None = None
        super().__init__(name, options.node, random, self._objects())
        self.add_pdos(
            {1: (_STATUS,), 2: (_STATUS, (0x6061, 0)), 3: (_STATUS, _POSITION), 4: (_STATUS, _VELOCITY)},
            {1: (_CONTROL,), 2: (_CONTROL, (0x6060, 0)), 3: (_CONTROL,), 4: (_CONTROL, _TARGET)},
        )

    def master_lost(self, now_ns: int) -> None:
        """As 6007h says; only a quick stop, or nothing, is emulated."""
        if self.dictionary.value(0x6007) == _QUICK_STOP and self._machine.state == OPERATION_ENABLED:
            self._become(QUICK_STOP_ACTIVE, now_ns)

    def _verbs(self) -> Mapping[str, Verb]:
        return {
            **super()._verbs(),
            "tripped": Verb(self._trip, self._recover),
            "encoder_lost": Verb(self._lose_encoder, self._find_encoder),
            "reset": Verb(self.reboot, lambda _: None),
        }

    def _power_up(self, now_ns: int) -> None:
        super()._power_up(now_ns)
        self._zero = self._shaft(now_ns)
        self._frozen = None
        self._become(SWITCH_ON_DISABLED, now_ns)
        for verb, begin in (("tripped", self._trip), ("encoder_lost", self._lose_encoder)):
            if verb in self.faults:
                begin(now_ns)

    def _power_down(self) -> None:
        super()._power_down()
        self._stood_ns = NEVER_NS

    def lose_power(self, cause: str, now_ns: int) -> None:
        """Without power it rolls."""
        self._shaft.release(now_ns)
        super().lose_power(cause, now_ns)

    def _next_ns(self) -> int:
        return min(super()._next_ns(), self._stood_ns)

    def _step(self, now_ns: int) -> None:
        super()._step(now_ns)
        if now_ns >= self._stood_ns:
            self._become(SWITCH_ON_DISABLED, now_ns)

    def _objects(self) -> Mapping[Key, Item]:
        return {
            (0x1000, 0): Item("I", _DEVICE_TYPE, writable=False),
            (0x6007, 0): Item("h", 1),
            _CONTROL: Item("H", mappable=True, written=self._controlled),
            _STATUS: Item("H", read=lambda _: self._machine.word, writable=False, mappable=True),
            (0x605A, 0): Item("h", 2, writable=False),
            (0x6060, 0): Item("b", mappable=True, written=self._moded),
            (0x6061, 0): Item(
                "b", read=lambda _: self.dictionary.value(0x6060), writable=False, mappable=True
            ),
            _POSITION: Item("i", read=self._position, writable=False, mappable=True),
            _VELOCITY: Item("i", read=self._velocity, writable=False, mappable=True),
            _TARGET: Item("i", mappable=True, written=self._targeted),
            (0x6502, 0): Item("I", 1 << _PROFILE_VELOCITY - 1, writable=False),
        }

    def _controlled(self, word: int, now_ns: int) -> None:
        before = self._machine.state
        after = self._machine.commanded(word, "tripped" in self.faults or "encoder_lost" in self.faults)
        if after != before:
            self._become(after, now_ns)

    def _moded(self, mode: int, now_ns: int) -> None:
        del now_ns
        if mode not in _MODES:
            raise AbortError(INVALID_VALUE)

    def _targeted(self, target: int, now_ns: int) -> None:
        self._turn(target, now_ns)

    def _become(self, state: int, now_ns: int) -> None:
        """What follows from a state."""
        self._machine.state = state
        self._stood_ns = now_ns + _QUICK_STOP_NS if state == QUICK_STOP_ACTIVE else NEVER_NS
        if state == OPERATION_ENABLED:
            self._turn(self.dictionary.value(*_TARGET), now_ns)
        elif state == QUICK_STOP_ACTIVE:
            self._shaft.drive(0.0, now_ns)
        else:
            self._shaft.release(now_ns)
        self.changed(_STATUS, now_ns)

    def _turn(self, target: int, now_ns: int) -> None:
        if self._machine.state == OPERATION_ENABLED and self.dictionary.value(0x6060) == _PROFILE_VELOCITY:
            self._shaft.drive(target / self._units_per_turn() * tau / self._options.gear, now_ns)

    def _trip(self, now_ns: int) -> None:
        self._fail(_OVER_CURRENT, now_ns)

    def _recover(self, now_ns: int) -> None:
        self._mend(_OVER_CURRENT, now_ns)

    def _lose_encoder(self, now_ns: int) -> None:
        self._frozen = self._position(now_ns)
        self._fail(_ENCODER, now_ns)

    def _find_encoder(self, now_ns: int) -> None:
        """It begins to count anew."""
        self._frozen, self._zero = None, self._shaft(now_ns)
        self._mend(_ENCODER, now_ns)

    def _fail(self, code: int, now_ns: int) -> None:
        if self.powered:
            self._machine.fail()
            self._become(self._machine.state, now_ns)
            self.alarm(code, _REGISTERS[code], now_ns)

    def _mend(self, code: int, now_ns: int) -> None:
        """Somebody has mended it, and reset its fault."""
        self.calm(code, now_ns)
        if "tripped" not in self.faults and "encoder_lost" not in self.faults:
            self._become(SWITCH_ON_DISABLED, now_ns)

    def _turns(self, now_ns: int) -> float:
        return self._shaft(now_ns) / tau * self._options.gear

    def _position(self, now_ns: int) -> int:
        if self._frozen is not None:
            return self._frozen
        turns = self._turns(now_ns) - self._zero / tau * self._options.gear
        span = self._options.range_counts or 1 << 32
        counts = self._options.origin + floor(turns * self._options.counts_per_turn)
        return (counts + span // 2) % span - span // 2

    def _velocity(self, now_ns: int) -> int:
        if self._frozen is not None:
            return 0
        turned = self._turns(now_ns) - self._turns(now_ns - _SLOPE_NS)
        return round(turned / _SLOPE_NS * 1e9 * self._units_per_turn())

    def _units_per_turn(self) -> float:
        return self._options.velocity_units or self._options.counts_per_turn
