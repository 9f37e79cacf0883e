"""Wheels that count: the right distance or a flag, whatever fails; a robot on two of them."""

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from math import cos, degrees, hypot, sin, tau
from random import Random
from typing import Any

import numpy as np
import pytest

from echogrid.drivers import registry
from echogrid.drivers.device import Level, State
from echogrid.drivers.readings import WheelReading
from echogrid.drivers.role import WheelRole
from echogrid.emulation.buses.can_bus import CanBus
from echogrid.emulation.devices.can_node import CanNode
from echogrid.emulation.models import WHEELS
from echogrid.emulation.offices import office_tour
from echogrid.mapping.pose import wrap_angle
from echogrid.runtime import evaluation, offline
from echogrid.runtime.config import Config
from echogrid.runtime.hardware_config import WheelConfig
from echogrid.runtime.loop import SECOND_NS
from echogrid.runtime.simulated_run import START_NS

MS = 1_000_000
TICK_NS = 10 * MS
FASTEST = 20.0
BEGIN_NS = START_NS
FINENESS = {"vesc": tau / 42, "ak-servo": tau / 3600}
"""rad of a count."""


def to_and_fro(now_ns: int) -> float:
    """Many turns in both directions, at up to 12 rad/s."""
    t = now_ns / SECOND_NS
    return 24.0 * sin(0.5 * t) + 3.0 * cos(0.3 * t)


def onward(now_ns: int) -> float:
    """8 rad/s, for ever."""
    return 8.0 * now_ns / SECOND_NS


class Trial:
    """A driver and its emulated controller on one bus."""

    def __init__(self, model: str, angle: Callable[[int], float], **options: Any) -> None:
        self.node = WHEELS[model].build("wheel", angle, Random(1), {"node": 9, **options})
        assert isinstance(self.node, CanNode)
        self.bus = CanBus("can", 500_000, [self.node])
        self.bus.switch_on(BEGIN_NS)
        driver = registry.driver(model)
        self.driver = driver(WheelRole("wheel", fastest=FASTEST), driver.Settings(node=9))
        self.now_ns = BEGIN_NS
        self.readings: list[WheelReading] = []
        self.states: list[State] = []
        self._angle = angle
        self._fineness = FINENESS[model]

    def run(self, seconds: float) -> set[State]:
        """Go on so long; the states that the driver told."""
        before = len(self.states)
        end_ns = self.now_ns + round(seconds * SECOND_NS)
        while self.now_ns < end_ns:
            self.now_ns += TICK_NS
            given = self.driver.step(self.now_ns, self.bus.take(self.now_ns)).readings
            self.readings += [reading for reading in given if isinstance(reading, WheelReading)]
            self.states.append(self.driver.health(self.now_ns).state)
        return set(self.states[before:])

    def assert_never_silently_wrong(self) -> int:
        """Each step is that of the true wheel, or none and flagged; the number of flags."""
        for old, new in pairwise(self.readings):
            moved = 0.0 if new.discontinuity else self._angle(new.stamp_ns) - self._angle(old.stamp_ns)
            assert abs(new.angle - old.angle - moved) <= (0.0 if new.discontinuity else 1.2 * self._fineness)
        return sum(reading.discontinuity for reading in self.readings)


models = pytest.mark.parametrize("model", FINENESS)


@models
@pytest.mark.parametrize("angle", [to_and_fro, onward])
def test_every_turn_is_counted_over_all_wraps(model: str, angle: Callable[[int], float]) -> None:
    trial = Trial(model, angle)
    trial.run(60.0)
    assert trial.assert_never_silently_wrong() == 0
    first, last = trial.readings[0], trial.readings[-1]
    assert last.angle - first.angle == pytest.approx(
        angle(last.stamp_ns) - angle(first.stamp_ns), abs=1.2 * FINENESS[model]
    )
    assert set(trial.states[100:]) == {State.WELL}


@pytest.mark.parametrize("start", [(1 << 31) - 1000, -(1 << 31) + 1000])
def test_a_tachometer_that_wraps_at_32_bits_goes_on(start: int) -> None:
    trial = Trial("vesc", to_and_fro, origin=start)
    trial.run(40.0)
    assert trial.assert_never_silently_wrong() == 0


@models
@pytest.mark.parametrize("verb", ["off", "unplug"])
@pytest.mark.parametrize("lasts_s", [0.05, 0.6, 3.0])
@pytest.mark.parametrize("since_s", [2.0, 3.7, 11.0])
def test_a_restart_is_one_discontinuity(model: str, verb: str, lasts_s: float, since_s: float) -> None:
    trial = Trial(model, to_and_fro)
    trial.run(since_s)
    trial.node.fault(verb, trial.now_ns, round(lasts_s * SECOND_NS))
    states = trial.run(lasts_s + 2.0)
    assert (State.SILENT in states) == (lasts_s > 0.1)
    assert trial.assert_never_silently_wrong() == 1
    assert trial.states[-1] is State.WELL


@models
@pytest.mark.parametrize(("lasts_s", "flags"), [(1.0, 0), (4.0, 1)])
def test_an_unplugged_adapter_is_the_right_distance_or_a_flag(model: str, lasts_s: float, flags: int) -> None:
    """After a second there is no doubt; after four it could have come from zero, or from half round."""
    trial = Trial(model, onward)
    trial.run(5.0)
    trial.bus.fault("unplug", trial.now_ns, round(lasts_s * SECOND_NS))
    trial.driver.lost(trial.now_ns)
    trial.run(lasts_s + 1.0)
    assert trial.assert_never_silently_wrong() == flags
    assert trial.states[-1] is State.WELL


@models
def test_a_bad_contact_gives_the_right_distance_or_a_flag(model: str) -> None:
    trial = Trial(model, to_and_fro)
    trial.run(4.0)
    trial.node.fault("intermittent", trial.now_ns, 10 * SECOND_NS)
    assert trial.run(10.0) >= {State.WELL, State.SILENT}
    trial.assert_never_silently_wrong()
    trial.run(1.0)
    assert trial.states[-1] is State.WELL


@pytest.mark.parametrize(
    ("model", "verb", "state"),
    [
        ("vesc", "garbage", State.FAULTY),
        ("vesc", "delayed", State.WELL),
        ("vesc", "overheated", State.HOT),
        ("ak-servo", "garbage", State.FAILED),
        ("ak-servo", "delayed", State.WELL),
        ("ak-servo", "overheated", State.FAILED),
        ("ak-servo", "encoder_lost", State.FAILED),
    ],
)
def test_a_fault_has_its_state_and_goes_with_it(model: str, verb: str, state: State) -> None:
    trial = Trial(model, to_and_fro)
    trial.run(2.0)
    trial.node.fault(verb, trial.now_ns, 3 * SECOND_NS)
    trial.run(2.9)
    assert trial.states[-1] is state
    trial.run(1.5)
    assert trial.states[-1] is State.WELL


def test_a_lost_encoder_is_no_motion() -> None:
    trial = Trial("ak-servo", to_and_fro)
    trial.run(2.0)
    trial.node.fault("encoder_lost", trial.now_ns, SECOND_NS)
    trial.run(3.0)
    assert trial.assert_never_silently_wrong() == 1


def test_a_vesc_without_status_5_is_told_so() -> None:
    trial = Trial("vesc", onward, messages=0b001111)
    trial.run(2.0)
    assert trial.readings == []
    health = trial.driver.health(trial.now_ns)
    assert (health.state, health.level) == (State.STALLED, Level.STALE)
    assert "STATUS_5" in health.message


def test_an_actuator_that_stops_counting_is_told_so() -> None:
    trial = Trial("ak-servo", onward, ends="stop")
    trial.run(12.0)
    trial.assert_never_silently_wrong()
    assert trial.states[-1] is State.FAULTY


def wheels_of(config: Config, driver: str, **settings: int) -> Config:
    """The robot with other controllers on its wheels."""
    left = WheelConfig("left", driver, "wheel_bus", settings={"node": 0, **settings})
    right = WheelConfig("right", driver, "wheel_bus", settings={"node": 1, **settings})
    return replace(config, wheel=(left, right))


def book_config() -> Config:
    """The emulated robot's, with a map whose cells depend on their own pings alone."""
    config = evaluation.default_config()
    return replace(config, map=replace(config.map, theory="bayes"))


def drive(config: Config) -> tuple[np.ndarray[Any, Any], float, float]:
    """Eight metres through the office: which cells the map holds for occupied, how far its last pose is
    off (m), and by how much it is turned (degrees)."""
    tape = evaluation.drive_tour(config, 3, 8.0)
    recording = evaluation.recorded(config, tape)
    stamp_ns, pose = recording.poses[-1]
    found = evaluation.start_of(office_tour(), tape).compose(pose)
    x, y, yaw = office_tour().pose((stamp_ns - START_NS) / SECOND_NS)
    image = offline.build(recording).image
    occupied = (image.occupancy > evaluation.OCCUPIED) & ~image.unknown
    return occupied, hypot(found.x - x, found.y - y), degrees(abs(wrap_angle(found.yaw - yaw)))


@pytest.fixture(scope="module")
def on_odrives() -> np.ndarray[Any, Any]:
    occupied, _, _ = drive(book_config())
    return occupied


@pytest.mark.parametrize(
    ("driver", "settings", "alike"), [("vesc", {"pole_pairs": 15}, 0.85), ("ak-servo", {}, 0.98)]
)
def test_a_robot_on_two_of_them_maps_as_one_on_two_odrives(
    on_odrives: np.ndarray[Any, Any], driver: str, settings: dict[str, int], alike: float
) -> None:
    """A VESC counts every 4 mm here, 0.75 deg of the robot: some borders move by a cell."""
    occupied, off, turned = drive(wheels_of(book_config(), driver, **settings))
    assert off < 0.03
    assert turned < 0.8
    assert np.sum(occupied & on_odrives) > alike * np.sum(occupied | on_odrives)
