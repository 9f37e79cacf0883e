"""The I2CXL, the URM09 and URM13 and the RCWL-9620 with their emulated chips, on the jumping clock."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from math import inf
from random import Random

from hypothesis import given, settings
from hypothesis.strategies import floats, sampled_from
from pytest import approx, mark

from echogrid.drivers import registry
from echogrid.drivers.commanded import CommandedRanger
from echogrid.drivers.device import State
from echogrid.drivers.readings import Outcome, RangeReading
from echogrid.drivers.role import RangerRole
from echogrid.emulation.devices.i2c_chip import I2cChip
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.models import RANGERS
from echogrid.emulation.scene import Echo

from .i2c_bench import MS, SPEED, Joined

SECOND = 1_000 * MS
LOOK, LOOKS = 50 * MS, 70
CENTIMETRE = 0.00501
RESOLUTION = {"i2cxl": CENTIMETRE, "rcwl-9620": 1e-6, "urm09": CENTIMETRE, "urm13-i2c": CENTIMETRE}
"""m."""
NEAREST = {"i2cxl": 0.22, "rcwl-9620": 0.06, "urm09": 0.06, "urm13-i2c": 0.41}
"""m: from where on each tells distances."""

drivers = mark.parametrize("driver", RESOLUTION)


class Rig(Joined):
    """One ranger before a wall."""

    def __init__(
        self,
        driver: str,
        distance: float | None,
        speed: float = SPEED,
        options: Mapping[str, int] | None = None,
    ) -> None:
        """`speed` is that of the emulated air; the driver is told 343 m/s. `options` are the chip's."""
        echoes = () if distance is None else (Echo(distance, 40.0, "wall"),)
        surroundings = Surroundings(lambda fire_ns: echoes, speed)
        self.chip = RANGERS[driver].build(driver, surroundings, Random(1), options or {})
        assert isinstance(self.chip, I2cChip)
        made = registry.driver(driver)
        device = made(RangerRole(driver, 0.05, 4.0, None, SPEED), made.Settings())
        assert isinstance(device, CommandedRanger)
        super().__init__([self.chip], [device])

    def fault(self, verb: str, for_ns: int) -> None:
        self.chip.fault(verb, self.clock.now_ns(), for_ns)

    @property
    def state(self) -> State:
        (state,) = self.states()
        return state


@dataclass(frozen=True, slots=True)
class Course:
    """What a fault did."""

    states: Counter[State]
    """When it had settled: how often each was seen."""
    outcomes: Counter[Outcome]
    """Of the readings meanwhile."""
    recovery_s: float
    """From its end to a right reading of a device that is well."""

    @property
    def state(self) -> State:
        """The one that was seen most often."""
        return self.states.most_common(1)[0][0]


def course_of(driver: str, verb: str) -> Course:
    """What a fault does that lasts 6 s, of which the last 3.5 are looked at."""
    rig = Rig(driver, 1.2)
    rig.run(3 * SECOND)
    rig.fault(verb, 6 * SECOND)
    rig.run(6 * SECOND - LOOKS * LOOK)
    states, outcomes = Counter[State](), Counter[Outcome]()
    for _ in range(LOOKS):
        outcomes.update(reading.outcome for reading in rig.run(LOOK))
        states[rig.state] += 1
    return Course(states, outcomes, recovery_s(rig, driver))


def recovery_s(rig: Rig, driver: str) -> float:
    """How long until a reading is right and the device well; infinite if that does not come."""
    right = approx(1.2, abs=RESOLUTION[driver])
    for look in range(1, 200):
        if any(reading.distance == right for reading in rig.run(LOOK)) and rig.state is State.WELL:
            return look * LOOK / SECOND
    return inf


@drivers
@given(share=floats(0.0, 1.0), speed=sampled_from([325.0, SPEED, 355.0]))
@settings(max_examples=15)
def test_a_wall_is_seen_within_the_resolution(driver: str, share: float, speed: float) -> None:
    distance = NEAREST[driver] + share * (3.7 - NEAREST[driver])
    has_thermometer = driver.startswith("urm")
    expected = distance if has_thermometer else distance * SPEED / speed
    readings = Rig(driver, distance, speed).run(2 * SECOND)
    assert len(readings) >= 5
    assert [reading.distance for reading in readings] == approx(
        [expected] * len(readings), abs=RESOLUTION[driver]
    )


@drivers
def test_nothing_is_told_as_such(driver: str) -> None:
    outcomes = {reading.outcome for reading in Rig(driver, None).run(2 * SECOND)}
    assert outcomes == {Outcome.NO_ECHO}


def test_what_is_nearer_than_an_i2cxl_tells_is_too_close() -> None:
    for distance in (0.05, 0.15, 0.2):
        readings = Rig("i2cxl", distance).run(2 * SECOND)
        assert {reading.outcome for reading in readings} == {Outcome.TOO_CLOSE}


def test_the_part_information_of_an_i2cxl_is_never_taken_for_a_range() -> None:
    """It would be 2.66 m."""
    rig = Rig("i2cxl", 1.0)
    readings: list[RangeReading] = rig.run(SECOND)
    rig.fault("off", SECOND)
    readings += rig.run(4 * SECOND)
    assert max(reading.distance for reading in readings) == approx(1.0, abs=CENTIMETRE)


@mark.parametrize(
    ("driver", "configuration"),
    [
        *(("urm09", value) for value in (0x00, 0x20, 0x80, 0xA0)),
        *(("urm13-i2c", value) for value in (0x00, 0x04, 0x10, 0x14)),
    ],
)
def test_whatever_a_urm_was_set_to_it_is_set_anew(driver: str, configuration: int) -> None:
    rig = Rig(driver, 1.2, options={"configuration": configuration})
    rig.run(SECOND)
    assert {reading.distance for reading in rig.run(SECOND)} == {1.2}
    assert rig.state is State.WELL


def test_a_urm09_that_lost_its_configuration_with_its_power_is_set_anew() -> None:
    rig = Rig("urm09", 3.5)
    rig.run(SECOND)
    rig.fault("off", 10 * MS)
    readings = rig.run(3 * SECOND)
    assert readings[-1].distance == 3.5
    assert {reading.outcome for reading in readings} <= {Outcome.ECHO, Outcome.INVALID}


@drivers
def test_a_bad_contact_comes_and_goes(driver: str) -> None:
    course = course_of(driver, "intermittent")
    assert {State.WELL, State.MISSING} <= set(course.states)
    assert course.recovery_s < 3.0


def test_garbage_of_an_rcwl_9620_passes_now_and_then() -> None:
    course = course_of("rcwl-9620", "garbage")
    assert State.FAULTY in course.states
    assert course.outcomes[Outcome.INVALID] > 0
    assert course.recovery_s < 3.0


@mark.parametrize("driver", ["i2cxl", "urm09", "urm13-i2c"])
def test_garbage_is_hardly_ever_believed(driver: str) -> None:
    assert course_of(driver, "garbage").outcomes[Outcome.ECHO] <= 1


def test_an_rcwl_9620_that_is_too_slow_looks_like_one_that_hears_nothing() -> None:
    outcomes = course_of("rcwl-9620", "slow").outcomes
    assert outcomes[Outcome.NO_ECHO] > outcomes[Outcome.ECHO]
    assert set(outcomes) <= {Outcome.NO_ECHO, Outcome.ECHO}
