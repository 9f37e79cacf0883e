"""Noise, bent words and true ones thrown at the driver of a serial device, through its public door."""

from itertools import pairwise
from math import isnan
from random import Random
from typing import Any

from echogrid.drivers import registry
from echogrid.drivers.device import State, Step
from echogrid.drivers.readings import Outcome, RangeReading
from echogrid.drivers.yaw_gyro import is_for_gyros

from .corpus import MS, START_NS, UNASKED, conversed, emulated, recorded, subject
from .tally import Tally

BLOCK = 4_000
"""Bytes between two looks whether it finds its feet."""
FEET_NS = 6_000 * MS
"""A ranger which is spoken to has found them after so long: twice its longest back-off, and some turns."""
AHEAD_NS = 50 * MS
"""So far ahead of the clock the stamp of one that is spoken to may be: here replies come at once, but the
request and the sound take their time."""


def serial_drivers() -> list[str]:
    """All rangers on serial lines."""
    drivers = {name: registry.driver(name) for name in registry.BUILT_IN}
    return [name for name, each in drivers.items() if each.bus == "serial" and not is_for_gyros(each)]


def fuzz(name: str, count: int, seed: int) -> Tally:
    """Feed a driver at least so many bytes; what it does that it must not ends in `faults`, with the seed."""
    ordeal = Ordeal(name, seed)
    try:
        while ordeal.tally.fed < count:
            ordeal.disturb(min(BLOCK, count - ordeal.tally.fed))
            ordeal.calm_down()
    except Exception as error:  # noqa: BLE001 - any is what is looked for
        ordeal.blame(f"raises {error!r}")
    return ordeal.tally


class Ordeal:
    """One driver, and what is done to it. All chance comes from the seed."""

    def __init__(self, name: str, seed: int) -> None:
        self.tally = Tally(name, "bytes")
        self._name, self._seed = name, seed
        self._random = Random(f"{name}/{seed}")
        self._words = recorded(name, seed)
        self._all_words = [word for words in self._words.values() for word in words]
        self._line, self._role = subject(name)
        self._wire = emulated(name, seed)
        self._streams = UNASKED in self._words
        self._ahead_ns = 0 if self._streams else AHEAD_NS
        self._now_ns = START_NS
        self._request = UNASKED
        self._due_ns = START_NS

    def disturb(self, count: int) -> None:
        """So many bytes of all kinds."""
        until = self.tally.fed + count
        while self.tally.fed < until:
            if not self._streams and self._random.random() < 0.1:
                self._wait()
            for chunk in self._cut(self._speech()):
                self._feed(chunk, self._random.randrange(20 * MS))
            if self._random.random() < 0.001:
                self._line.lost(self._now_ns)

    def calm_down(self) -> None:
        """See whether it understands true words again."""
        if self._streams:
            self._find_frame()
        else:
            self._find_feet()
        self.tally.resyncs += 1

    def blame(self, what: str) -> None:
        """Note what it must not do."""
        self.tally.blame(what, self._seed)

    def _find_frame(self) -> None:
        """Of two messages the second is read, as by a device that heard no noise before."""
        (fresh, _), given, expected = subject(self._name), [], ()
        for word in self._random.choices(self._all_words, k=2):
            given = self._feed(word, 50 * MS)
            expected = fresh.step(self._now_ns, [word]).readings
        if _told(given) != _told(expected):
            self.blame(f"reads {_told(given)} after noise where {_told(expected)} was said")

    def _find_feet(self) -> None:
        """With a true device at the other end for a while it is well, and reads what is said."""
        self._wire.take(self._now_ns)
        until_ns, right = self._now_ns + FEET_NS, 0
        for now_ns, _, step in conversed(self._line, self._wire, self._now_ns, until_ns):
            self._note(now_ns, step)
            right += sum(reading.outcome is not Outcome.INVALID for reading in step.readings)
        (device,) = self._line.devices
        state = device.health(self._now_ns).state
        if state is not State.WELL or not right:
            self.blame(f"is {state.value} after {FEET_NS // MS} ms of truth, with {right} readings")

    def _speech(self) -> bytes:
        """What to say now: nothing, noise, true words, bent ones."""
        kind = self._random.random()
        if kind < 0.05 and not self._streams:
            return b""
        if kind < 0.3:
            return self._random.randbytes(self._random.choice((1, 3, 4, 8, 20, 200)))
        words = self._words.get(self._request, self._all_words)
        said = b"".join(self._random.choices(words, k=1 if kind < 0.7 else 5))
        return said if kind < 0.45 else self._bent(said)

    def _bent(self, data: bytes) -> bytes:
        """With some bytes changed, lost, doubled and put in."""
        bent = bytearray(data)
        for _ in range(self._random.randint(1, 1 + len(bent) // 8)):
            at = self._random.randrange(len(bent) + 1)
            match self._random.randrange(4):
                case 0:
                    bent[at : at + 1] = self._random.randbytes(1)
                case 1:
                    del bent[at : at + 1]
                case 2:
                    bent[at:at] = bent[at : at + 1]
                case _:
                    bent[at:at] = self._random.randbytes(self._random.randint(1, 3))
        return bytes(bent)

    def _cut(self, data: bytes) -> list[bytes]:
        """In one piece, in a few, or byte by byte."""
        kind = self._random.random()
        if kind < 0.6 or len(data) < 2:
            return [data]
        if kind < 0.65:
            return [data[at : at + 1] for at in range(len(data))]
        cuts = sorted(self._random.randrange(len(data)) for _ in range(3))
        return [data[a:b] for a, b in pairwise((0, *cuts, len(data))) if b > a]

    def _feed(self, chunk: bytes, after_ns: int) -> list[RangeReading]:
        """Let time pass, and let it hear that; until then it does what it wants to."""
        given, at_ns = [], self._now_ns + after_ns
        while self._due_ns < at_ns:
            given += self._step(max(self._due_ns, self._now_ns), ())
        self.tally.fed += len(chunk)
        return given + self._step(at_ns, (chunk,) if chunk else ())

    def _wait(self) -> list[RangeReading]:
        """Let time pass until it wants something."""
        return self._step(max(self._due_ns, self._now_ns), ())

    def _step(self, now_ns: int, received: tuple[bytes, ...]) -> list[RangeReading]:
        step = self._line.step(now_ns, received)
        self._note(now_ns, step)
        return list(step.readings)

    def _note(self, now_ns: int, step: Step[Any]) -> None:
        self._now_ns = now_ns
        self._due_ns = max(step.deadline_ns, now_ns + 1)
        if step.send:
            self._request = tuple(step.send)
        for reading in step.readings:
            self._check(reading)
        self.tally.readings += len(step.readings)

    def _check(self, reading: RangeReading) -> None:
        inside = self._role.nearest <= reading.distance < self._role.farthest
        possible = inside if reading.outcome is Outcome.ECHO else isnan(reading.distance)
        if not possible:
            self.blame(f"gives {reading}")
        if not 0 <= reading.stamp_ns <= self._now_ns + self._ahead_ns:
            self.blame(f"gives a stamp of {reading.stamp_ns} at {self._now_ns}")


def _told(readings: Any) -> list[tuple[Outcome, float, bytes]]:
    return [(each.outcome, -1.0 if isnan(each.distance) else each.distance, each.raw) for each in readings]
