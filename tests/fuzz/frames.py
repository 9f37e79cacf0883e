"""Noise, bent frames and true ones thrown at the driver of a wheel on CAN, through its public door."""

from collections.abc import Sequence
from dataclasses import replace
from math import isfinite
from random import Random
from typing import Any

from tests.drivers.candump import logged
from tests.drivers.controllers import CONTROLLERS, FASTEST, RATES, Controller, drift, golden

from echogrid.drivers.bus import FD_LENGTHS, CanFrame
from echogrid.drivers.device import Line, State, Step
from echogrid.drivers.readings import WheelReading
from echogrid.drivers.role import WheelRole
from echogrid.drivers.throttle import Throttle
from echogrid.emulation.buses.can_bus import CanBus

from .tally import Tally

MS = 1_000_000
START_NS = 10_000 * MS
BLOCK = 5_000
"""Frames between two looks whether it finds its feet."""
EVILS = (0.001, 0.01, 0.1, 0.7)
"""Of all frames so many are none of the device's."""
WHEEL = "left"
RESTS_NS = 3_000 * MS
"""So long nothing comes before it is to find them."""
FEET_NS = 5_000 * MS
"""It has found them after so long: set up again, and the second look of any doubt over."""
LOOK_NS = 1_000 * MS
"""And is then right for so long."""
TICK_NS = 10 * MS
SLACK_S = 0.02
"""Frames read late in one go are stamped closer together than they were sent."""
ROUNDING = 1e-3
"""rad."""


def can_drivers() -> list[str]:
    """All wheels on CAN, by the rows of their table."""
    return list(CONTROLLERS)


def fuzz(name: str, count: int, seed: int) -> Tally:
    """Feed a driver so many frames; what it does that it must not ends in `faults`, with the seed."""
    ordeal = Ordeal(CONTROLLERS[name], Tally(name, "frames"), seed)
    try:
        while ordeal.tally.fed < count:
            ordeal.disturb(min(BLOCK, count - ordeal.tally.fed))
            ordeal.calm_down()
    except Exception as error:  # noqa: BLE001 - any is what is looked for
        ordeal.tally.blame(f"raises {error!r}", seed)
    return ordeal.tally


class Ordeal:
    """One driver, and what is done to it. All chance comes from the seed."""

    def __init__(self, controller: Controller, tally: Tally, seed: int) -> None:
        self.tally = tally
        self._seed = seed
        self._controller = controller
        self._random = Random(f"{tally.driver}/{seed}")
        self._words = logged(golden(tally.driver).read_text())
        self._throttle = Throttle(10.0, 20.0)
        device = controller.made(WHEEL, WheelRole(WHEEL, fastest=FASTEST, throttle=self._throttle))
        self._line: Line[Any, Any] = Line("line", [device])
        self._lengths = FD_LENGTHS if any(frame.fd for frame in self._words) else range(9)
        self._now_ns = self._due_ns = START_NS
        self._at = 0
        self._last: WheelReading | None = None

    def disturb(self, count: int) -> None:
        """So many frames of all kinds."""
        until, evil = self.tally.fed + count, self._random.choice(EVILS)
        while self.tally.fed < until:
            self._pass(self._random.choice((0, MS, self._random.randrange(20 * MS))))
            if self._random.random() < 0.001:
                self._pass(self._random.randrange(2_000 * MS))
            self._drive()
            said = self._speech(evil)[: until - self.tally.fed]
            self.tally.fed += len(said)
            self._step(said)
            if self._random.random() < 0.0005:
                self._line.lost(self._now_ns)
                self._due_ns = self._now_ns

    def calm_down(self) -> None:
        """With a true controller on the bus for a while it is well, and reads how its wheel turns."""
        self._throttle.release()
        self._pass(RESTS_NS)
        start_ns = self._now_ns
        node = self._controller.emulated(WHEEL, lambda now_ns: RATES[WHEEL] * (now_ns - start_ns) * 1e-9)
        bus = CanBus("bus", 1_000_000, [node])
        bus.switch_on(start_ns)
        readings: list[WheelReading] = []
        while self._now_ns < start_ns + FEET_NS:
            self._now_ns += TICK_NS
            step = self._step(bus.take(self._now_ns))
            bus.send(step.send, self._now_ns)
            readings += [each for each in step.readings if isinstance(each, WheelReading)]
        self._judge([each for each in readings if each.stamp_ns > self._now_ns - LOOK_NS])
        self.tally.resyncs += 1

    def _judge(self, readings: Sequence[WheelReading]) -> None:
        """What it says of the truth."""
        (device,) = self._line.devices
        health = device.health(self._now_ns)
        if health.state is not State.WELL or len(readings) < 9:
            told = f"is {health.state.value} ({health.message}) with {len(readings)} readings"
            self._blame(f"{told} after {FEET_NS // MS} ms of truth")
        elif abs(drift(readings, RATES[WHEEL])) > 2 * self._controller.fineness + ROUNDING:
            self._blame(f"is off by {drift(readings, RATES[WHEEL])} rad in the truth")

    def _blame(self, what: str) -> None:
        self.tally.blame(what, self._seed)

    def _drive(self) -> None:
        """Somebody wants it to turn now and then."""
        kind = self._random.random()
        if kind < 0.02:
            self._throttle.ask(self._now_ns, self._random.choice((0.0, self._random.uniform(-20.0, 20.0))))
        elif kind < 0.023:
            self._throttle.release()

    def _speech(self, evil: float) -> list[CanFrame]:
        """What is said now: true frames in their order; of these so many are bent, or noise."""
        words = self._words[self._at : self._at + self._random.choice((1, 1, 2, 4))]
        self._at += len(words)
        if self._at >= len(self._words):
            self._at = self._random.randrange(len(self._words))
        return [
            self._stamped(self._changed(frame) if self._random.random() < evil else frame) for frame in words
        ]

    def _changed(self, frame: CanFrame) -> CanFrame:
        return self._bent(frame) if self._random.random() < 0.6 else self._noise(frame)

    def _bent(self, frame: CanFrame) -> CanFrame:
        """With one thing changed."""
        data = bytearray(frame.data)
        match self._random.randrange(8):
            case 0:
                return replace(frame, identifier=frame.identifier ^ 1 << self._random.randrange(11))
            case 1:
                return replace(frame, extended=not frame.extended, identifier=frame.identifier & 0x7FF)
            case 2:
                return replace(frame, remote=not frame.remote, data=b"", fd=False)
            case 3:
                length = self._random.choice([each for each in self._lengths if each <= len(data)])
                return replace(frame, data=frame.data[:length])
            case 4:
                length = self._random.choice(self._lengths)
                return replace(frame, data=(frame.data + self._random.randbytes(length))[:length])
            case _:
                for _ in range(self._random.choice((1, 1, 2, 8))):
                    if data:
                        data[self._random.randrange(len(data))] ^= 1 << self._random.randrange(8)
                return replace(frame, data=bytes(data))

    def _noise(self, frame: CanFrame) -> CanFrame:
        """Chance in a frame of that kind, or in any."""
        if self._random.random() < 0.7:
            return replace(frame, data=self._random.randbytes(len(frame.data)))
        extended = self._random.random() < 0.5
        identifier = self._random.getrandbits(29 if extended else 11)
        data = self._random.randbytes(self._random.choice(self._lengths))
        return CanFrame(identifier, data, extended, fd=len(data) > 8)

    def _stamped(self, frame: CanFrame) -> CanFrame:
        """As if it had come just now, or some time ago; by some adapters there is no stamp."""
        age_ns = self._random.choice((0, 0, 0, 0, self._random.randrange(50 * MS)))
        return replace(frame, stamp_ns=self._now_ns - age_ns if self._random.random() < 0.95 else 0)

    def _pass(self, for_ns: int) -> None:
        """Let time pass; it does what it wants to meanwhile."""
        at_ns = self._now_ns + for_ns
        while self._due_ns < at_ns:
            self._now_ns = max(self._due_ns, self._now_ns)
            self._step(())
        self._now_ns = at_ns

    def _step(self, received: Sequence[CanFrame]) -> Step[CanFrame]:
        step = self._line.step(self._now_ns, received)
        self._due_ns = max(step.deadline_ns, self._now_ns + 1)
        for reading in step.readings:
            if isinstance(reading, WheelReading):
                self._check(reading)
        for frame in step.send:
            if not (0 <= frame.identifier < 1 << 29 and len(frame.data) in self._lengths):
                self._blame(f"sends {frame}")
        if not self._line.devices[0].health(self._now_ns).message:
            self._blame("says nothing")
        self.tally.readings += len(step.readings)
        return step

    def _check(self, new: WheelReading) -> None:
        """No wheel turns faster than it can, and none at all over a discontinuity."""
        old, self._last = self._last, new
        if not (isfinite(new.angle) and isfinite(new.rate)) or not 0 < new.stamp_ns <= self._now_ns:
            self._blame(f"gives {new}")
        if abs(new.rate) > 2 * FASTEST:
            self._blame(f"gives {new}")
        if old is None:
            return
        lasted_s = (new.stamp_ns - old.stamp_ns) * 1e-9
        coarseness = self._controller.coarseness + ROUNDING
        reach = 0.0 if new.discontinuity else FASTEST * (lasted_s + SLACK_S) + coarseness
        if lasted_s < 0.0 or abs(new.angle - old.angle) > reach + ROUNDING:
            self._blame(f"gives {new} after {old}")
