from collections.abc import Callable, Sequence
from dataclasses import replace

import pytest

from echogrid.drivers.a02yyuw import A02yyuw
from echogrid.drivers.device import Line, Step
from echogrid.drivers.readings import Outcome, RangeReading
from echogrid.drivers.role import RangerRole

from . import streams
from .corpus import SPEED

BYTES = 200_000


@pytest.mark.parametrize("driver", streams.serial_drivers())
def test_no_driver_of_a_serial_device_is_upset_by_noise(driver: str) -> None:
    tally = streams.fuzz(driver, BYTES, seed=1)
    assert tally.faults == []
    assert tally.fed >= BYTES
    assert tally.readings > 100
    assert tally.resyncs > 20


class Upset(A02yyuw):
    """A driver with a fault."""

    def __init__(self, role: RangerRole, fault: Callable[[bytes, RangeReading], RangeReading | None]) -> None:
        super().__init__(role, A02yyuw.Settings())
        self._fault = fault

    def step(self, now_ns: int, received: Sequence[bytes]) -> Step[bytes]:
        told = super().step(now_ns, received).readings
        readings = [self._fault(received[0], each) for each in told if isinstance(each, RangeReading)]
        return Step(tuple(reading for reading in readings if reading))


def choke(chunk: bytes, reading: RangeReading) -> RangeReading:
    if len(chunk) % 7 == 0:
        raise IndexError("index out of range")
    return reading


def reach_too_far(chunk: bytes, reading: RangeReading) -> RangeReading:
    return replace(reading, outcome=Outcome.ECHO, distance=7.0)


def measure_nothing(chunk: bytes, reading: RangeReading) -> RangeReading:
    return replace(reading, outcome=Outcome.NO_ECHO)


def foresee(chunk: bytes, reading: RangeReading) -> RangeReading:
    return replace(reading, stamp_ns=reading.stamp_ns + 10_000_000_000)


def miss(chunk: bytes, reading: RangeReading) -> RangeReading | None:
    return None if len(chunk) == 4 else reading


@pytest.mark.parametrize(
    ("fault", "found"),
    [
        (choke, "raises IndexError"),
        (reach_too_far, "gives RangeReading"),
        (measure_nothing, "gives RangeReading"),
        (foresee, "gives a stamp of"),
        (miss, "after noise where"),
    ],
)
def test_a_driver_that_does_what_it_must_not_is_found_out(
    monkeypatch: pytest.MonkeyPatch,
    fault: Callable[[bytes, RangeReading], RangeReading | None],
    found: str,
) -> None:
    role = RangerRole("upset", 0.05, 4.0, None, SPEED)
    upset, whole = iter([(Line("line", [Upset(role, fault)]), role)]), streams.subject
    monkeypatch.setattr(streams, "subject", lambda name: next(upset, None) or whole(name))
    tally = streams.fuzz("a02yyuw", 20_000, seed=1)
    assert any(found in each for each in tally.faults)


def test_the_same_seed_gives_the_same_ordeal() -> None:
    assert streams.fuzz("maxbotix", 20_000, seed=7) == streams.fuzz("maxbotix", 20_000, seed=7)
