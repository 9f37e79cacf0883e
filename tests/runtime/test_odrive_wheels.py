"""ODrive drivers with their emulated axes, and with each other's: the right distance, a flag, or the mend."""

from itertools import pairwise
from math import cos, sin, tau
from random import Random
from struct import pack
from typing import Any

import pytest

from echogrid.drivers import registry
from echogrid.drivers.bus import CanFrame
from echogrid.drivers.device import State
from echogrid.drivers.readings import WheelReading
from echogrid.drivers.role import WheelRole
from echogrid.emulation.buses.can_bus import CanBus
from echogrid.emulation.devices.can_node import CanNode
from echogrid.emulation.models import WHEELS

SECOND_NS = 1_000_000_000
TICK_NS = 10_000_000
BEGIN_NS = 5 * SECOND_NS
NODE = 9
FASTEST = 20.0
SET_POSITION = NODE << 5 | 0x019
COUNTS = {"counts_per_turn": 8192}
FLOAT32_STEP = 2.0**-7 * tau
"""rad, at 100 000 turns."""
KINDS = [("odrive-0.5", {}), ("odrive-0.5", COUNTS), ("odrive-0.6", {})]


def to_and_fro(now_ns: int) -> float:
    """Many turns in both directions, at up to 12 rad/s."""
    t = now_ns / SECOND_NS
    return 24.0 * sin(0.5 * t) + 3.0 * cos(0.3 * t)


class Trial:
    """A driver and an emulated axis on one bus, which both use."""

    def __init__(
        self, name: str, settings: dict[str, Any] | None = None, axis: str = "", **options: Any
    ) -> None:
        listen_only = options.pop("listen_only", False)
        shared = settings or {}
        self.node = WHEELS[axis or name].build(
            "wheel", to_and_fro, Random(1), {"node": NODE, **shared, **options}
        )
        assert isinstance(self.node, CanNode)
        self.bus = CanBus("can", 500_000, [self.node])
        self.bus.switch_on(BEGIN_NS)
        driver = registry.driver(name)
        role = WheelRole("wheel", fastest=FASTEST, listen_only=listen_only)
        self.driver = driver(role, driver.Settings(node=NODE, **shared))
        self.now_ns = BEGIN_NS
        self.readings: list[WheelReading] = []
        self.sent: list[CanFrame] = []
        self.states: list[State] = []

    def run(self, seconds: float) -> list[State]:
        """Go on so long; the states that the driver told, the first of each in a row."""
        before = len(self.states)
        end_ns = self.now_ns + round(seconds * SECOND_NS)
        while self.now_ns < end_ns:
            self.now_ns += TICK_NS
            step = self.driver.step(self.now_ns, self.bus.take(self.now_ns))
            self.bus.send(step.send, self.now_ns)
            self.sent += step.send
            self.readings += [reading for reading in step.readings if isinstance(reading, WheelReading)]
            self.states.append(self.driver.health(self.now_ns).state)
        told = self.states[before:]
        return told[:1] + [new for old, new in pairwise(told) if new is not old]

    @property
    def message(self) -> str:
        """What the driver says now."""
        return self.driver.health(self.now_ns).message

    def assert_never_silently_wrong(self) -> int:
        """Each step is that of the true wheel, or none and flagged; the number of flags."""
        for old, new in pairwise(self.readings):
            moved = 0.0 if new.discontinuity else to_and_fro(new.stamp_ns) - to_and_fro(old.stamp_ns)
            assert abs(new.angle - old.angle - moved) <= 0.01
        return sum(reading.discontinuity for reading in self.readings)


kinds = pytest.mark.parametrize(("name", "settings"), KINDS, ids=["0.5", "0.5 counts", "0.6"])


@kinds
@pytest.mark.parametrize("listen_only", [False, True])
def test_every_turn_is_counted(name: str, settings: dict[str, Any], listen_only: bool) -> None:
    trial = Trial(name, settings, listen_only=listen_only)
    trial.run(30.0)
    assert trial.assert_never_silently_wrong() == 0
    first, last = trial.readings[0], trial.readings[-1]
    assert last.angle - first.angle == pytest.approx(
        to_and_fro(last.stamp_ns) - to_and_fro(first.stamp_ns), abs=0.01
    )
    assert set(trial.states[100:]) == {State.WELL}
    assert bool(trial.sent) is not listen_only


@kinds
@pytest.mark.parametrize("verb", ["off", "unplug"])
@pytest.mark.parametrize("lasts_s", [0.05, 0.6, 3.0])
def test_a_restart_is_one_flagged_discontinuity(
    name: str, settings: dict[str, Any], verb: str, lasts_s: float
) -> None:
    trial = Trial(name, settings)
    trial.run(3.7)
    trial.node.fault(verb, trial.now_ns, round(lasts_s * SECOND_NS))
    states = trial.run(lasts_s + 2.0)
    assert (State.SILENT in states) == (lasts_s > 0.5)
    assert trial.assert_never_silently_wrong() == 1
    assert trial.states[-1] is State.WELL


@kinds
@pytest.mark.parametrize(
    ("verb", "state"),
    [("encoder_lost", State.FAILED), ("motor_failed", State.FAILED), ("off", State.SILENT)],
)
def test_a_fault_is_told_and_over_when_it_is_over(
    name: str, settings: dict[str, Any], verb: str, state: State
) -> None:
    trial = Trial(name, settings)
    trial.run(2.0)
    trial.node.fault(verb, trial.now_ns, 2 * SECOND_NS)
    assert trial.run(1.9)[-1] is state
    trial.run(3.0)
    assert trial.states[-1] is State.WELL
    assert trial.assert_never_silently_wrong() == (verb == "off")


@kinds
@pytest.mark.parametrize("verb", ["garbage", "intermittent", "delayed"])
@pytest.mark.parametrize("since_s", [0.0, 2.0])
def test_after_noise_and_bad_contacts_it_is_well_again(
    name: str, settings: dict[str, Any], verb: str, since_s: float
) -> None:
    trial = Trial(name, settings)
    trial.run(since_s)
    trial.node.fault(verb, trial.now_ns, 2 * SECOND_NS)
    trial.run(2.5)
    heard = len(trial.readings)
    trial.run(12.0)
    assert trial.states[-1] is State.WELL
    assert len(trial.readings) > heard + 100
    del trial.readings[: heard + 1]
    assert trial.assert_never_silently_wrong() <= 1


@kinds
def test_an_adapter_that_was_away_costs_no_turn(name: str, settings: dict[str, Any]) -> None:
    trial = Trial(name, settings)
    trial.run(3.0)
    trial.bus.fault("unplug", trial.now_ns, SECOND_NS)
    trial.driver.lost(trial.now_ns)
    trial.run(3.0)
    assert trial.states[-1] is State.WELL
    assert trial.assert_never_silently_wrong() <= 1


def test_an_axis_of_0_6_at_the_driver_of_0_5_is_told_and_not_believed() -> None:
    trial = Trial("odrive-0.5", axis="odrive-0.6")
    trial.run(1.0)
    trial.readings.clear()
    trial.run(3.0)
    assert trial.states[-1] is State.WRONG_DEVICE
    assert trial.message == 'its firmware is 0.6.10: set driver = "odrive-0.6"'
    assert trial.readings == []


def test_an_axis_of_0_5_at_the_driver_of_0_6_is_told_and_not_believed() -> None:
    trial = Trial("odrive-0.6", axis="odrive-0.5")
    trial.run(3.0)
    assert trial.states[-1] is State.WRONG_DEVICE
    assert 'set driver = "odrive-0.5"' in trial.message
    assert trial.readings == []


@pytest.mark.parametrize("axis", ["odrive-0.5", "odrive-0.6"])
def test_a_lost_encoder_behind_the_wrong_driver_never_stands_at_zero(axis: str) -> None:
    trial = Trial("odrive-0.5" if axis == "odrive-0.6" else "odrive-0.6", axis=axis)
    trial.run(3.0)
    trial.readings.clear()
    trial.node.fault("encoder_lost", trial.now_ns)
    trial.run(3.0)
    assert trial.readings == []


def test_a_firmware_that_nobody_knows_is_told() -> None:
    trial = Trial("odrive-0.6", version="0.7.1")
    trial.run(3.0)
    assert (trial.states[-1], trial.message) == (
        State.WRONG_DEVICE,
        "its firmware is 0.7.1: there is no driver for it",
    )


def test_few_requests_are_sent_and_all_ask_for_the_version() -> None:
    trial = Trial("odrive-0.5")
    trial.run(60.0)
    assert trial.sent == [CanFrame(NODE << 5, b"", remote=True)] * 5


def test_the_counts_wrap_in_both_directions() -> None:
    trial = Trial("odrive-0.5", COUNTS)
    trial.run(3.0)
    trial.bus.send((CanFrame(SET_POSITION, pack("<i", (1 << 31) - 1000)),), trial.now_ns)
    trial.run(0.5)
    flags = trial.assert_never_silently_wrong()
    trial.run(30.0)
    shadows = {reading.raw[3] >> 7 for reading in trial.readings[-2000:]}
    assert shadows == {0, 1}
    assert (trial.assert_never_silently_wrong(), flags) == (1, 1)


@pytest.mark.parametrize(
    ("name", "position"), [("odrive-0.5", pack("<i", 8192 * 500)), ("odrive-0.6", pack("<f", -500.0))]
)
def test_a_position_that_is_set_by_somebody_is_one_flagged_discontinuity(name: str, position: bytes) -> None:
    trial = Trial(name)
    trial.run(3.0)
    trial.bus.send((CanFrame(SET_POSITION, position),), trial.now_ns)
    trial.run(3.0)
    assert trial.assert_never_silently_wrong() == 1
    assert trial.states[-1] is State.WELL


def test_far_from_zero_estimates_are_coarse_and_counts_are_not() -> None:
    spreads = []
    for settings in ({}, COUNTS):
        trial = Trial("odrive-0.5", settings)
        trial.run(1.0)
        trial.bus.send((CanFrame(SET_POSITION, pack("<i", 100_000 * 8192)),), trial.now_ns)
        trial.run(1.0)
        errors = [reading.angle - to_and_fro(reading.stamp_ns) for reading in trial.readings[-50:]]
        spreads.append(max(errors) - min(errors))
    estimated, counted = spreads
    assert 0.02 < estimated < FLOAT32_STEP + 0.01
    assert counted < 0.01
