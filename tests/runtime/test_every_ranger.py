"""Two suites over all rangers: the same scene, and every fault."""

import pytest

from echogrid.drivers import registry
from echogrid.drivers.device import State
from echogrid.drivers.readings import Outcome
from echogrid.drivers.yaw_gyro import is_for_gyros
from echogrid.emulation import models
from echogrid.emulation.errors import UnknownVerbError

from .device_trial import Trial, course_of
from .rangers import RANGERS, VERBS, Ranger

COLD = 331.3
"""m/s at 0 degC, where the driver is told 20 degC."""
TOLD = 343.21

rangers = pytest.mark.parametrize("ranger", RANGERS.values(), ids=RANGERS.keys())


def test_no_ranger_is_left_out() -> None:
    drivers = {name: registry.driver(name) for name in registry.BUILT_IN}
    ours = {name for name, each in drivers.items() if each.bus != "can" and not is_for_gyros(each)}
    assert ours == set(RANGERS) == set(models.RANGERS)


@rangers
def test_every_ranger_sees_the_same_scene_within_its_resolution(ranger: Ranger) -> None:
    for distance in ranger.distances:
        trial = Trial(ranger.subject, distance)
        trial.run(2.0)
        readings = trial.run(2.0)
        assert len(readings) >= 2
        assert {reading.outcome for reading in readings} == {Outcome.ECHO}
        assert max(abs(reading.distance - distance) for reading in readings) <= ranger.resolution


@rangers
def test_every_ranger_tells_that_there_is_nothing(ranger: Ranger) -> None:
    trial = Trial(ranger.subject, None)
    trial.run(2.0)
    outcomes = {reading.outcome for reading in trial.run(2.0)}
    assert outcomes == ({ranger.nothing} if ranger.nothing else set())


@rangers
def test_a_wall_that_moves_is_followed_at_once(ranger: Ranger) -> None:
    near, far = ranger.distances[0], ranger.distances[-1]
    trial = Trial(ranger.subject, near)
    trial.run(3.0)
    trial.wall.distance = far
    trial.run(1.5)
    readings = trial.run(1.0)
    assert readings
    assert max(abs(reading.distance - far) for reading in readings) <= ranger.resolution


@rangers
def test_in_air_colder_than_told_only_those_with_a_thermometer_are_right(ranger: Ranger) -> None:
    distance = ranger.distances[1]
    trial = Trial(ranger.subject, distance, COLD)
    trial.run(2.0)
    expected = distance if ranger.thermometer else distance * TOLD / COLD
    readings = trial.run(2.0)
    assert readings
    for reading in readings:
        assert reading.distance == pytest.approx(expected, abs=1.1 * ranger.resolution)


FOLLOWS_S = 3.0
"""Every ranger is back so soon after every fault."""
BY_TURNS = {
    State.WELL,
    State.SETTING_UP,
    State.MISSING,
    State.STALLED,
    State.FAULTY,
    State.SILENT,
    State.GARBLED,
}
"""How one may look that comes and goes."""
LUCK = 0.5
"""Of what noise, or another device, brings so much at most looks like an echo."""


@pytest.mark.parametrize("verb", VERBS)
@rangers
def test_every_fault_has_its_state_and_its_way_back(ranger: Ranger, verb: str) -> None:
    distance = ranger.distances[1]
    if verb not in ranger.seen:
        with pytest.raises(UnknownVerbError, match=f"no fault '{verb}'"):
            Trial(ranger.subject, distance).fault(verb, 1.0)
        return
    course = course_of(ranger.subject, verb, distance, ranger.resolution)
    state = ranger.seen[verb]
    if state is None:
        assert set(course.states) - {State.WRONG_DEVICE} <= BY_TURNS
    else:
        assert course.state is state
    if state not in (State.WELL, State.FAULTY, None):
        assert course.outcomes[Outcome.ECHO] == 0
    assert course.recovery_s <= FOLLOWS_S


@rangers
def test_what_noise_brings_is_seldom_taken_for_an_echo(ranger: Ranger) -> None:
    outcomes = course_of(ranger.subject, "garbage", ranger.distances[1], ranger.resolution).outcomes
    assert outcomes[Outcome.ECHO] <= LUCK * max(outcomes.total(), 1)
