from dataclasses import dataclass
from math import sin

from hypothesis import given
from hypothesis import strategies as st

from echogrid.mapping.gyro import WIDEST_GAP_NS, Gyro
from echogrid.mapping.kinematics import Differential
from echogrid.mapping.odometry import Odometry
from echogrid.mapping.pose import Pose
from echogrid.mapping.reckoning import Reckoning, YawRate
from echogrid.mapping.wheel_pair import WheelAngles
from echogrid.mapping.yaw_fusion import YawFusion

MS = 1_000_000
SECOND = 1000 * MS
Entry = YawRate | WheelAngles
Poses = list[tuple[int, Pose]]


def reckoning(with_gyro: bool = True) -> Reckoning:
    fusion = YawFusion(Gyro(), 1e-6) if with_gyro else None
    return Reckoning(Odometry(Differential(0.06, 0.06, 0.32, 1e-4), fusion))


def wheels_at(stamp_ms: int, spins: bool = False) -> WheelAngles:
    """At rest for two seconds, then to and fro; one wheel may spin in the fourth second."""
    t = max(stamp_ms / 1000.0 - 2.0, 0.0)
    angle = 4.0 * sin(t)
    extra = 3.0 * min(max(t - 2.0, 0.0), 1.0) if spins else 0.0
    return WheelAngles(stamp_ms * MS, angle - 0.3 * t, angle + 0.3 * t + extra)


def rate_at(stamp_ms: int) -> YawRate:
    turning = 2.0 * 0.3 * 0.06 / 0.32 if stamp_ms > 2000 else 0.0
    return YawRate(stamp_ms * MS, turning + 0.01)


def told(state: Reckoning, entries: list[Entry]) -> tuple[Poses, list[YawRate]]:
    """The poses, and the rates that were taken."""
    poses: Poses = []
    taken = []
    for entry in entries:
        if isinstance(entry, WheelAngles):
            assert state.wheels(entry)
        elif state.rate(entry):
            taken.append(entry)
        poses += state.poses()
    return poses + state.finish(), taken


def in_order(entries: list[Entry]) -> list[Entry]:
    return sorted(entries, key=lambda entry: (entry.stamp_ns, isinstance(entry, WheelAngles)))


Spells = list[tuple[int, int]]


@dataclass(frozen=True)
class Course:
    """Wheels and rates with delays and outages of their own; wheels come in portions. All in ms."""

    lasts: int
    wheels_every: int
    rates_every: int
    first_rate: int
    wheels_late: int
    rates_late: int
    portion: int
    pauses: Spells
    silences: Spells

    def entries(self) -> list[Entry]:
        """In the order in which they come."""
        coming: list[tuple[int, int, Entry]] = []
        for stamp_ms in told_at(range(0, self.lasts, self.wheels_every), self.pauses):
            come_ms = -(-(stamp_ms + self.wheels_late) // self.portion) * self.portion
            coming.append((come_ms, len(coming), wheels_at(stamp_ms, spins=True)))
        for stamp_ms in told_at(range(self.first_rate, self.lasts, self.rates_every), self.silences):
            coming.append((stamp_ms + self.rates_late, len(coming), rate_at(stamp_ms)))
        return [entry for _, _, entry in sorted(coming, key=lambda each: each[:2])]


def told_at(stamps: range, outages: Spells) -> list[int]:
    return [at for at in stamps if not any(start <= at < start + length for start, length in outages)]


SPELLS = st.lists(st.tuples(st.integers(0, 6000), st.integers(1, 1500)), max_size=3)
DELAYS = st.integers(0, 400)
COURSES = st.builds(
    Course,
    lasts=st.integers(3000, 6000),
    wheels_every=st.integers(7, 40),
    rates_every=st.integers(5, 120),
    first_rate=st.integers(0, 900),
    wheels_late=DELAYS,
    rates_late=DELAYS,
    portion=st.integers(1, 300),
    pauses=SPELLS,
    silences=SPELLS,
)


@given(COURSES)
def test_the_poses_are_those_of_what_was_taken_put_in_order(course: Course) -> None:
    entries = course.entries()
    live, taken = told(reckoning(), entries)
    wheels = [entry for entry in entries if isinstance(entry, WheelAngles)]
    offline, again = told(reckoning(), in_order([*wheels, *taken]))
    assert again == taken
    assert live == offline


@given(COURSES)
def test_without_a_gyro_nothing_waits(course: Course) -> None:
    state = reckoning(with_gyro=False)
    for entry in course.entries():
        if isinstance(entry, YawRate):
            assert not state.rate(entry)
        else:
            state.wheels(entry)
            assert [stamp_ns for stamp_ns, _ in state.poses()] == [entry.stamp_ns]


def test_the_wheels_wait_until_the_gyro_covers_them() -> None:
    state = reckoning()
    state.rate(rate_at(0))
    state.wheels(wheels_at(5))
    state.wheels(wheels_at(15))
    assert state.poses() == []
    state.rate(rate_at(10))
    assert [stamp_ns for stamp_ns, _ in state.poses()] == [5 * MS]
    state.rate(rate_at(20))
    assert [stamp_ns for stamp_ns, _ in state.poses()] == [15 * MS]


def test_before_the_first_rate_nothing_waits() -> None:
    state = reckoning()
    state.wheels(wheels_at(5))
    assert len(state.poses()) == 1


def test_a_gyro_that_falls_silent_is_waited_for_no_longer_than_it_bridges() -> None:
    state = reckoning()
    state.rate(rate_at(0))
    behind = []
    for stamp_ms in range(0, 1000, 10):
        state.wheels(wheels_at(stamp_ms))
        newest = [stamp_ns for stamp_ns, _ in state.poses()][-1:]
        behind += [stamp_ms * MS - newest[0]] if newest else []
    assert behind[:2] == [0, 0]
    assert behind[2:] == [0] * (100 - 27)
    assert state.finish() == []


def test_rates_of_a_time_that_was_reckoned_without_them_are_refused() -> None:
    state = reckoning()
    state.rate(rate_at(0))
    state.wheels(wheels_at(WIDEST_GAP_NS // MS + 1))
    assert len(state.poses()) == 1
    assert not state.rate(rate_at(10))
    assert state.refused == 1
    assert state.rate(rate_at(WIDEST_GAP_NS // MS + 2))


def test_a_gyro_that_is_late_is_found_again_after_a_silence() -> None:
    state, late_ms = reckoning(), 60
    taken = []
    for now_ms in range(0, 5000, 10):
        speaks = not 1000 <= now_ms < 2000
        if now_ms >= late_ms and speaks:
            taken += [now_ms] if state.rate(rate_at(now_ms - late_ms)) else []
        state.wheels(wheels_at(now_ms))
        state.poses()
    assert len([now_ms for now_ms in taken if now_ms >= 2000]) > 280
    assert state.refused < 20


def test_angles_that_are_not_later_are_not_taken() -> None:
    state = reckoning()
    assert state.wheels(wheels_at(10))
    assert not state.wheels(wheels_at(10))
    assert not state.wheels(wheels_at(5))


def test_a_gyro_without_wheels_is_remembered_within_bounds() -> None:
    state = reckoning()
    for stamp_ms in range(0, 100_000, 10):
        state.rate(rate_at(stamp_ms))
    state.wheels(wheels_at(99_500))
    state.wheels(wheels_at(99_600))
    assert len(state.poses()) == 2
