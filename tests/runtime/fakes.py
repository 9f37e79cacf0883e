"""Small stand-ins for what surrounds the parts under test."""

from collections import deque
from collections.abc import Callable, Mapping, Sequence

from echogrid.drivers.bus import NEVER_NS
from echogrid.drivers.device import Health, State, Step
from echogrid.drivers.errors import PortError
from echogrid.drivers.readings import Outcome, RangeReading, Reading, WheelReading

MS = 1_000_000
SECOND = 1_000_000_000


class HandClock:
    """Stands still, but for sleeping and for `late_ns`: how much longer each of the next sleeps takes."""

    def __init__(self, now_ns: int = 0, late_ns: Sequence[int] = ()) -> None:
        self.time_ns = now_ns
        self.late_ns = deque(late_ns)

    def now_ns(self) -> int:
        return self.time_ns

    def sleep_until_ns(self, deadline_ns: int) -> None:
        self.time_ns = max(self.time_ns, deadline_ns) + (self.late_ns.popleft() if self.late_ns else 0)


class ScriptedPort:
    """Gives one item of `script` a read, and then nothing; an exception in it is raised."""

    def __init__(self, script: Sequence[object] = (), refusals: int = 0) -> None:
        self.script = deque(script)
        self.refusals = refusals
        self.is_open = False
        self.opened = 0
        self.sent: list[bytes] = []

    def open(self) -> None:
        if self.refusals:
            self.refusals -= 1
            raise PortError("/dev/fake: not there (plug it in)")
        self.is_open = True
        self.opened += 1

    def close(self) -> None:
        self.is_open = False

    def write(self, items: Sequence[bytes]) -> None:
        self.sent += items

    def read(self, timeout_s: float) -> Sequence[bytes]:
        item = self.script.popleft() if self.script else b""
        if isinstance(item, Exception):
            raise item
        assert isinstance(item, bytes)
        return (item,) if item else ()

    def ready_ns(self) -> int:
        return 0 if self.script else NEVER_NS


class Parrot:
    """A device which makes a reading of each chunk; `bite` is raised in its next step."""

    port_options: Mapping[str, object] = {}

    def __init__(
        self, name: str = "parrot", deadline_ns: Callable[[int], int] = lambda now: NEVER_NS
    ) -> None:
        self.name = name
        self.losses: list[int] = []
        self.bite: Exception | None = None
        self._deadline_ns = deadline_ns

    def step(self, now_ns: int, received: Sequence[bytes]) -> Step[bytes]:
        if self.bite is not None:
            bite, self.bite = self.bite, None
            raise bite
        readings = tuple(echo(now_ns, 1.0, self.name, raw) for raw in received)
        return Step(readings, tuple(received), self._deadline_ns(now_ns))

    def lost(self, now_ns: int) -> None:
        self.losses.append(now_ns)

    def health(self, now_ns: int) -> Health:
        return Health(State.WELL, "talking", {"losses": len(self.losses)})


class MishapError(Exception):
    """What a driver should not raise."""


def echo(stamp_ns: int, distance: float = 1.0, sensor: str = "front", raw: bytes = b"") -> RangeReading:
    return RangeReading(stamp_ns, 0, sensor, Outcome.ECHO, distance, raw)


def told(stamp_ns: int, outcome: Outcome, sensor: str = "front") -> RangeReading:
    return RangeReading(stamp_ns, 0, sensor, outcome)


def wheels(stamp_ns: int, left: float, right: float) -> tuple[Reading, Reading]:
    return (
        WheelReading(stamp_ns, 0, "left", left, 0.0),
        WheelReading(stamp_ns, 0, "right", right, 0.0),
    )
