from collections.abc import Callable, Sequence
from dataclasses import replace
from math import nan

import pytest
from tests.drivers.controllers import Controller

from echogrid.drivers.bus import CanFrame
from echogrid.drivers.device import Step
from echogrid.drivers.readings import WheelReading
from echogrid.drivers.role import WheelRole
from echogrid.drivers.vesc import Vesc

from . import frames

FRAMES = 100_000


@pytest.mark.parametrize("driver", frames.can_drivers())
def test_no_driver_of_a_wheel_on_can_is_upset_by_noise(driver: str) -> None:
    tally = frames.fuzz(driver, FRAMES, seed=1)
    assert tally.faults == []
    assert tally.fed == FRAMES
    assert tally.readings > FRAMES / 20
    assert tally.resyncs == FRAMES / frames.BLOCK


Fault = Callable[[WheelReading], WheelReading | None]


class Upset(Vesc):
    """A driver with a fault."""

    def __init__(self, role: WheelRole, fault: Fault) -> None:
        super().__init__(role, Vesc.Settings(node=1))
        self._fault = fault

    def step(self, now_ns: int, received: Sequence[CanFrame]) -> Step[CanFrame]:
        step = super().step(now_ns, received)
        told = [self._fault(each) for each in step.readings if isinstance(each, WheelReading)]
        return replace(step, readings=tuple(each for each in told if each))


def choke(reading: WheelReading) -> WheelReading:
    if reading.raw[3] == 7:
        raise IndexError("index out of range")
    return reading


def race(reading: WheelReading) -> WheelReading:
    return replace(reading, angle=reading.angle * 50)


def slip(reading: WheelReading) -> WheelReading:
    return replace(reading, angle=reading.angle * 1.3)


def move_over_a_flag(reading: WheelReading) -> WheelReading:
    return replace(reading, discontinuity=True)


def lose_count(reading: WheelReading) -> WheelReading:
    return replace(reading, angle=nan)


def foresee(reading: WheelReading) -> WheelReading:
    return replace(reading, stamp_ns=reading.stamp_ns + 10_000_000_000)


def miss(reading: WheelReading) -> WheelReading | None:
    return None


@pytest.mark.parametrize(
    ("fault", "found"),
    [
        (choke, "raises IndexError"),
        (race, "gives WheelReading"),
        (slip, "is off by"),
        (move_over_a_flag, "gives WheelReading"),
        (lose_count, "gives WheelReading"),
        (foresee, "gives WheelReading"),
        (miss, "with 0 readings after"),
    ],
)
def test_a_driver_that_does_what_it_must_not_is_found_out(
    monkeypatch: pytest.MonkeyPatch, fault: Fault, found: str
) -> None:
    def upset(controller: Controller, wheel: str, role: WheelRole) -> Upset:
        return Upset(role, fault)

    monkeypatch.setattr(Controller, "made", upset)
    tally = frames.fuzz("vesc", 10_000, seed=1)
    assert any(found in each for each in tally.faults)


def test_the_same_seed_gives_the_same_ordeal() -> None:
    assert frames.fuzz("vesc", 10_000, seed=7) == frames.fuzz("vesc", 10_000, seed=7)
