"""An emulated Roboteq motor controller: one of its channels with a wheel, in CANopen or MiniCAN mode."""

import struct
from collections.abc import Callable, Mapping
from dataclasses import replace
from random import Random

from echogrid.drivers.bus import NEVER_NS, CanFrame
from echogrid.emulation.devices.can_node import CanNode
from echogrid.emulation.devices.canopen_node import CanopenNode
from echogrid.emulation.devices.canopen_objects import Item, Key
from echogrid.emulation.devices.device import LOOKED_UP
from echogrid.emulation.devices.roboteq_counter import RoboteqCounter, RoboteqOptions
from echogrid.emulation.faults import Verb

_STARTUP_NS = 400_000_000
"""From power-up until it counts and sends: a guess."""
_AUTOSTART_NS = 10_000_000
"""From its boot-up message until it is operational: a guess."""
_SPEED, _COUNTER, _BRUSHLESS, _VARIABLE = 0x2103, 0x2104, 0x2105, 0x2106
_RELATIVE_SPEED, _RELATIVE, _BRUSHLESS_RELATIVE, _BRUSHLESS_SPEED = 0x2107, 0x2108, 0x2109, 0x210A
_STATUS_FLAGS, _FAULT_FLAGS = (0x2111, 0), (0x2112, 0)
_BY_CHANNEL = {*range(_SPEED, _VARIABLE), *range(_RELATIVE_SPEED, _BRUSHLESS_SPEED + 1)}
_CHANNELS = (1, 2, 3)
_TPDOS = (1, 2, 3, 4)
_OFF = 1 << 31
"""In the identifier of a TPDO."""
_VARIABLES = 8
_OVERHEAT, _EMERGENCY_STOP = 0x01, 0x10
_SERIAL_MODE, _POWER_STAGE_OFF, _SCRIPT_RUNNING = 0x01, 0x08, 0x80
_START = 1
"""NMT."""


def roboteq(name: str, angle: Callable[[int], float], random: Random, options: RoboteqOptions) -> CanNode:
    """One in the mode of its options, without power."""
    if options.mode == "minican":
        return RoboteqMinican(name, angle, random, options)
    return RoboteqCanopen(name, angle, random, options)


class RoboteqCanopen(CanopenNode):
    """Serves its objects, and sends a TPDO with the variable into which its script copies the counter.

    Of the objects that each channel has it answers for its own and is silent for the others, so that two of
    one node on a bus are two channels of one controller.
    """

    def __init__(
        self, name: str, angle: Callable[[int], float], random: Random, options: RoboteqOptions
    ) -> None:
        self._options = options
        self._counter = RoboteqCounter(angle, options)
        self._script = Script(self._counter)
        self._auto_ns = NEVER_NS
        super().__init__(name, options.node, random, self._objects())
        self.dictionary.add({(0x1017, 0): Item("H", options.heartbeat_ms, written=self._produce)})
        self.add_pdos({number: _pair(number) for number in _TPDOS}, {})
        self.dictionary.add({key: item for number in _TPDOS for key, item in self._rate(number).items()})

    def master_lost(self, now_ns: int) -> None:
        """Nothing: its motor is not turned here."""

    def _verbs(self) -> Mapping[str, Verb]:
        return {
            **super()._verbs(),
            "overheated": LOOKED_UP,
            "emergency_stop": LOOKED_UP,
            "sdo_deaf": LOOKED_UP,
            "script_halted": Verb(self._script.halt, self._script.go_on),
        }

    def _power_up(self, now_ns: int) -> None:
        super()._power_up(now_ns)
        self._boot_ns = now_ns + _STARTUP_NS

    def _power_down(self) -> None:
        super()._power_down()
        self._auto_ns = NEVER_NS

    def _next_ns(self) -> int:
        return min(super()._next_ns(), self._auto_ns)

    def _step(self, now_ns: int) -> None:
        if now_ns >= self._boot_ns:
            self._counter.restart(now_ns)
            self._auto_ns = now_ns + _AUTOSTART_NS if self._options.start == "auto" else NEVER_NS
        super()._step(now_ns)
        if now_ns >= self._auto_ns:
            self._auto_ns = NEVER_NS
            self._commanded(_START, now_ns)

    def _serve(self, request: bytes, now_ns: int) -> None:
        index, sub = int.from_bytes(request[1:3], "little"), request[3]
        others = index in _BY_CHANNEL and sub in _CHANNELS and sub != self._options.channel
        if "sdo_deaf" not in self.faults and not others:
            super()._serve(request, now_ns)

    def _objects(self) -> Mapping[Key, Item]:
        counter, channel = self._counter, self._options.channel
        counts: Mapping[int, tuple[str, Callable[[int], int]]] = {
            _SPEED: ("i", counter.rpm),
            _COUNTER: ("i", counter.count),
            _RELATIVE_SPEED: ("h", counter.per_mille),
            _RELATIVE: ("i", counter.since_asked),
        }
        if self._options.encoder == "brushless":
            counts = {
                **{index: (form, _nothing) for index, (form, _) in counts.items()},
                _BRUSHLESS: ("i", counter.count),
                _BRUSHLESS_RELATIVE: ("i", counter.since_asked),
                _BRUSHLESS_SPEED: ("h", counter.rpm),
            }
        by_channel = {
            (index, channel): Item(form, read=read, writable=False, mappable=True)
            for index, (form, read) in counts.items()
        }
        variables = {
            (_VARIABLE, sub): Item("i", read=self._variable(sub), writable=False, mappable=True)
            for sub in range(1, _VARIABLES + 1)
        }
        flags = {
            _STATUS_FLAGS: Item("H", read=self._status_flags, writable=False, mappable=True),
            _FAULT_FLAGS: Item("H", read=self._fault_flags, writable=False, mappable=True),
        }
        return by_channel | variables | flags

    def _rate(self, number: int) -> Mapping[Key, Item]:
        """Of all its TPDOs only that with the variable has a rate."""
        settings = 0x17FF + number
        if self._options.source == "variable" and number == self._options.tpdo:
            return {(settings, 5): replace(self.dictionary.item(settings, 5), value=self._options.period_ms)}
        identifier = self.dictionary.item(settings, 1)
        return {(settings, 1): replace(identifier, value=identifier.value | _OFF)}

    def _variable(self, number: int) -> Callable[[int], int]:
        copied = self._options.source == "variable" and number == self._options.variable
        return self._script.variable if copied else _nothing

    def _fault_flags(self, now_ns: int) -> int:
        del now_ns
        hot, stopped = "overheated" in self.faults, "emergency_stop" in self.faults
        return (_OVERHEAT if hot else 0) | (_EMERGENCY_STOP if stopped else 0)

    def _status_flags(self, now_ns: int) -> int:
        runs = self._options.source == "variable" and "script_halted" not in self.faults
        off = self._fault_flags(now_ns)
        return _SERIAL_MODE | (_POWER_STAGE_OFF if off else 0) | (_SCRIPT_RUNNING if runs else 0)


class RoboteqMinican(CanNode):
    """Sends four TPDOs in turn, and a heartbeat. It hears nothing: there is no SDO, and no NMT."""

    def __init__(
        self, name: str, angle: Callable[[int], float], random: Random, options: RoboteqOptions
    ) -> None:
        self._options = options
        self._random = random
        self._counter = RoboteqCounter(angle, options)
        self._script = Script(self._counter)
        self._turn = 0
        self._start_ns = self._due_ns = self._beat_ns = NEVER_NS
        super().__init__(name)

    def receive(self, frame: CanFrame, now_ns: int) -> None:
        """Nothing: its motor is not turned here."""

    def _verbs(self) -> Mapping[str, Verb]:
        return {**super()._verbs(), "script_halted": Verb(self._script.halt, self._script.go_on)}

    def _power_up(self, now_ns: int) -> None:
        self._start_ns = now_ns + _STARTUP_NS

    def _power_down(self) -> None:
        self._start_ns = self._due_ns = self._beat_ns = NEVER_NS
        self.withdraw()

    def _next_ns(self) -> int:
        return min(self._start_ns, self._due_ns, self._beat_ns)

    def _step(self, now_ns: int) -> None:
        if now_ns >= self._start_ns:
            self._counter.restart(now_ns)
            self._turn, self._due_ns, self._start_ns = 0, now_ns, NEVER_NS
            self._beat_ns = now_ns if self._options.heartbeat_ms else NEVER_NS
        if now_ns >= self._beat_ns:
            self._send(0x700, b"\x05", now_ns)
            self._beat_ns += self._options.heartbeat_ms * 1_000_000
        if now_ns >= self._due_ns:
            self._send(0x180 + 0x100 * self._turn, self._payload(now_ns), now_ns)
            self._turn = (self._turn + 1) % 4
            self._due_ns += self._options.period_ms * 1_000_000

    def _payload(self, now_ns: int) -> bytes:
        values = [0] * 4
        values[self._options.variable - 1] = self._script.variable(now_ns)
        return minican(self._turn + 1, values)

    def _send(self, header: int, payload: bytes, now_ns: int) -> None:
        if "garbage" in self.faults:
            payload = self._random.randbytes(len(payload))
        self.post(CanFrame(header + self._options.node, payload), now_ns + self._delay_ns())


class Script:
    """A loop on the controller that copies its counter into a variable."""

    def __init__(self, counter: RoboteqCounter) -> None:
        self._counter = counter
        self._left: int | None = None

    def halt(self, now_ns: int) -> None:
        """The variable stays as it is."""
        self._left = self._counter.count(now_ns)

    def go_on(self, now_ns: int) -> None:
        """It runs again."""
        del now_ns
        self._left = None

    def variable(self, now_ns: int) -> int:
        """What is in the variable."""
        return self._counter.count(now_ns) if self._left is None else self._left


def minican(number: int, values: list[int]) -> bytes:
    """TPDO1 and 2 hold two variables of 32 bits each, TPDO3 four of 16 bits, which are 0, TPDO4 32 bits."""
    if number == 3:
        return bytes(8)
    if number == 4:
        return bytes(4)
    return struct.pack("<ii", *values[2 * number - 2 : 2 * number])


def _pair(number: int) -> tuple[Key, ...]:
    """The two variables that a TPDO of that number holds."""
    return (_VARIABLE, 2 * number - 1), (_VARIABLE, 2 * number)


def _nothing(now_ns: int) -> int:
    """What is not connected counts nothing."""
    del now_ns
    return 0
