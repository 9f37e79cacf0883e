from collections.abc import Iterable, Sequence
from dataclasses import replace
from math import hypot, inf

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from echogrid.drivers.readings import Outcome, RangeReading, Reading, WheelReading
from echogrid.mapping.long_term_map import MapImage
from echogrid.mapping.virtual_sensor import StopReason
from echogrid.runtime import assembly, offline
from echogrid.runtime.config import Config, FiringConfig, LocalConfig, MapConfig
from echogrid.runtime.fusion import Fusion, Snapshot
from echogrid.runtime.hardware_config import RobotConfig, SensorConfig
from echogrid.runtime.recording import Recording

from .fakes import MS, SECOND, echo, told, wheels

CONFIG = Config(
    robot=RobotConfig(wheel_radius_m=0.1, track_m=0.4),
    sensor=(
        SensorConfig("front", 0.1, 0.0, 0.0, 15.0, 0.1, 2.0),
        SensorConfig("left", 0.0, 0.1, 90.0, 15.0, 0.1, 2.0),
    ),
    map=MapConfig(width_m=6.0, height_m=6.0),
    local=LocalConfig(resolution_m=0.1, size_m=4.0),
)
VERIFIED = replace(CONFIG, firing=FiringConfig(verify=True))
CONFIGS = st.sampled_from([CONFIG, VERIFIED])
STAMPS = st.integers(0, 400).map(lambda step: SECOND + step * 10 * MS)
RANGES = st.builds(
    told, STAMPS, st.sampled_from([Outcome.NO_ECHO, Outcome.TOO_CLOSE, Outcome.INVALID]), st.just("left")
) | st.builds(echo, STAMPS, st.floats(0.1, 2.0), st.sampled_from(["front", "left"]))
WHEELS = st.builds(
    WheelReading, STAMPS, st.just(0), st.sampled_from(["left", "right"]), st.floats(-5, 5), st.just(0.0)
)
TICKS = st.lists(st.lists(RANGES | WHEELS, max_size=12), max_size=8)


def fusion(config: Config = CONFIG) -> Fusion:
    return assembly.fusion(config)


def drive(seconds: float = 4.0) -> list[Reading]:
    """Straight on at 0.2 m/s, fifty wheel readings a second."""
    return [
        reading
        for step in range(round(seconds * 50) + 1)
        for reading in wheels(SECOND + step * 20 * MS, step * 0.04, step * 0.04)
    ]


def in_wheel_order(readings: Iterable[Reading]) -> list[Reading]:
    """The same with the stamps of each wheel put in order, as its driver gives them."""
    stamps = {
        name: sorted(r.stamp_ns for r in readings if isinstance(r, WheelReading) and r.wheel == name)
        for name in ("left", "right")
    }
    return [
        replace(r, stamp_ns=stamps[r.wheel].pop(0)) if isinstance(r, WheelReading) else r for r in readings
    ]


def bits(image: MapImage) -> bytes:
    return image.occupancy.tobytes() + image.unknown.tobytes()


def ticked(state: Fusion, portions: Sequence[Sequence[Reading]]) -> list[Snapshot]:
    return [state.tick(SECOND + (n + 1) * 20 * MS, portion) for n, portion in enumerate(portions)]


@given(TICKS)
def test_the_same_readings_at_the_same_ticks_give_the_same_bits(portions: list[list[Reading]]) -> None:
    one, twin = fusion(), fusion()
    assert list(map(str, ticked(one, portions))) == list(map(str, ticked(twin, portions)))
    one.finish()
    twin.finish()
    assert bits(one.map_image()) == bits(twin.map_image())


@given(TICKS, CONFIGS)
def test_the_books_balance_at_every_tick(portions: list[list[Reading]], config: Config) -> None:
    state = fusion(config)
    made = 0
    for number, portion in enumerate(portions):
        state.tick(SECOND + number * 20 * MS, portion)
        made += sum(isinstance(reading, RangeReading) for reading in portion)
        assert state.ledger.produced == made
        assert state.ledger.balances(state.waiting)
    state.finish()
    assert state.waiting == 0
    assert state.ledger.balances(0)


@given(TICKS, CONFIGS)
def test_the_log_of_its_ticks_gives_the_same_map_offline(
    portions: list[list[Reading]], config: Config
) -> None:
    ordered = iter(in_wheel_order([*drive(), *(reading for portion in portions for reading in portion)]))
    state = fusion(config)
    ticks = [state.tick(SECOND, [next(ordered) for _ in range(len(drive()))])]
    ticks += [state.tick(2 * SECOND, [next(ordered) for _ in portion]) for portion in portions]
    state.finish()
    odometry = assembly.odometry(config)
    wheels = [w for tick in ticks for w in tick.wheels]
    poses = [(w.stamp_ns, odometry.update(w.stamp_ns, w.both)) for w in wheels]
    log = Recording(config, poses, [("log:1", reading) for tick in ticks for reading in tick.ranges])
    stamps = [stamp_ns for stamp_ns, _ in poses]
    assert stamps == sorted(set(stamps))
    made = offline.build(log)
    assert bits(made.image) == bits(state.map_image())
    assert made.ledger.balances(0)
    assert made.ledger.dropped["unverified"] == state.ledger.dropped["unverified"]


def test_into_which_ticks_readings_fall_does_not_change_the_map() -> None:
    readings = [*drive(), *(echo(SECOND + k * 50 * MS, 1.0 + 0.01 * k) for k in range(60))]
    readings.sort(key=lambda reading: reading.stamp_ns)
    one, other = fusion(), fusion()
    ticked(one, [readings])
    ticked(other, [readings[start : start + 7] for start in range(0, len(readings), 7)])
    one.finish()
    other.finish()
    assert one.ledger.fused == 60
    assert bits(one.map_image()) == bits(other.map_image())


def test_what_is_too_close_is_seen_by_the_local_grid_but_not_by_the_map() -> None:
    state = fusion()
    near = [told(SECOND + k * 50 * MS, Outcome.TOO_CLOSE) for k in range(10)]
    (snapshot,) = ticked(state, [[*drive(1.0), *near]])
    state.finish()
    assert state.map_image().unknown.all()
    assert state.ledger.dropped == {"too close": 10}
    assert snapshot.view.stop
    assert 0.0 < snapshot.view.sectors[0].nearest < 0.5


def test_what_is_invalid_is_seen_by_neither() -> None:
    state, blind = fusion(), fusion()
    faults = [told(SECOND + k * 50 * MS, Outcome.INVALID) for k in range(10)]
    (snapshot,) = ticked(state, [[*drive(1.0), *faults]])
    (unseeing,) = ticked(blind, [drive(1.0)])
    assert snapshot.view == unseeing.view
    state.finish()
    assert state.map_image().unknown.all()
    assert state.ledger.dropped == {"invalid": 10}


def test_a_reading_newer_than_the_last_pose_waits_for_the_next() -> None:
    state = fusion()
    (first,) = ticked(state, [[*drive(1.0), echo(2 * SECOND + 10 * MS)]])
    assert (state.waiting, first.drops) == (1, ())
    state.tick(3 * SECOND, drive(2.0)[-100:])
    assert state.finish() == ()
    assert state.ledger.fused == 1


def test_what_comes_too_late_for_the_map_is_counted_and_not_for_the_log() -> None:
    state = fusion()
    (snapshot,) = ticked(state, [[*drive(), echo(4 * SECOND), echo(2 * SECOND), echo(4 * SECOND - 1)]])
    assert [reading.stamp_ns for reading in snapshot.ranges] == [4 * SECOND, 4 * SECOND - 1]
    assert [(drop.reading.stamp_ns, drop.reason) for drop in snapshot.drops] == [(2 * SECOND, "late")]


def test_what_gave_way_in_the_queue_is_in_the_books() -> None:
    state = fusion()
    state.overflow([echo(SECOND), told(SECOND, Outcome.NO_ECHO), *wheels(SECOND, 0, 0)])
    state.tick(SECOND, [])
    assert state.ledger.dropped == {"queue full": 2}
    assert state.ledger.balances(0)


def test_the_pose_and_the_way_are_those_of_the_wheels() -> None:
    (snapshot,) = ticked(fusion(), [drive(4.0)])
    assert hypot(snapshot.pose.x, snapshot.pose.y) == pytest.approx(0.8)
    assert snapshot.travelled == pytest.approx(0.8)
    assert len(snapshot.wheels) == 201


def test_the_pose_is_the_less_sure_the_further_the_robot_went() -> None:
    (short,), (long,) = ticked(fusion(), [drive(1.0)]), ticked(fusion(), [drive(4.0)])
    spread = 0.005**2 / 2.0
    assert short.covariance[0, 0] == pytest.approx(0.2 * spread)
    assert long.covariance[0, 0] == pytest.approx(0.8 * spread)
    assert np.linalg.eigvalsh(long.covariance - short.covariance).min() >= 0.0


def test_a_wheel_reading_given_twice_is_one_move() -> None:
    once, twice = fusion(), fusion()
    readings = drive(1.0)
    doubled = [reading for reading in readings for _ in range(2)]
    (one,), (two,) = ticked(once, [readings]), ticked(twice, [doubled])
    assert [angles.stamp_ns for angles in two.wheels] == [angles.stamp_ns for angles in one.wheels]
    assert two.pose == one.pose


def test_the_snapshot_s_arrays_are_its_own() -> None:
    state = fusion()
    ticked(state, [[*drive(1.0), echo(SECOND + 500 * MS)]])
    state.finish()
    before = state.map_image()
    kept = before.occupancy.copy()
    state.tick(3 * SECOND, [*drive(2.0)[-100:], echo(2 * SECOND + 500 * MS, 0.4)])
    state.finish()
    np.testing.assert_array_equal(before.occupancy, kept)


def test_unverified_readings_reach_neither_grid_but_the_stop_layer() -> None:
    believing, comparing = fusion(), fusion(VERIFIED)
    (lone,) = ticked(comparing, [[*drive(1.0), echo(SECOND + 900 * MS, 0.3)]])
    (believed,) = ticked(believing, [[*drive(1.0), echo(SECOND + 900 * MS, 0.3)]])
    assert lone.view.stop
    assert believed.view.sectors[0].nearest < 0.6
    assert lone.view.sectors[0].nearest == inf
    comparing.finish()
    assert comparing.map_image().unknown.all()
    assert comparing.ledger.dropped == {"unverified": 1}


def free_ahead() -> list[Reading]:
    """Ten pings of each sensor that hear something from afar."""
    stamps = [SECOND + k * 50 * MS for k in range(10)]
    return [echo(stamp_ns, 1.9, name) for stamp_ns in stamps for name in ("front", "left")]


def test_one_near_echo_stops_the_robot_where_the_grid_sees_none() -> None:
    wide = replace(CONFIG, sensor=tuple(replace(each, half_angle_deg=60.0) for each in CONFIG.sensor))
    config = replace(wide, firing=FiringConfig(verify=True))
    (free,) = ticked(fusion(config), [[*drive(1.0), *free_ahead()]])
    (near,) = ticked(fusion(config), [[*drive(1.0), *free_ahead(), echo(SECOND + 600 * MS, 0.3)]])
    assert near.view.sectors == free.view.sectors
    assert (free.view.reason, near.view.reason) == (None, StopReason.NEAR)


def test_turns_that_only_listened_are_counted_and_go_nowhere_else() -> None:
    state = fusion()
    outcomes = [Outcome.TOO_CLOSE, Outcome.ECHO, Outcome.NO_ECHO, Outcome.NO_ECHO, Outcome.INVALID]
    listened = [
        RangeReading(SECOND + k * 100 * MS, 0, "front", outcome, 0.2, listened=True)
        for k, outcome in enumerate(outcomes)
    ]
    (snapshot,) = ticked(state, [[*drive(1.0), *listened]])
    (unseeing,) = ticked(fusion(), [drive(1.0)])
    assert snapshot.ranges == ()
    assert snapshot.view == unseeing.view
    assert state.ledger.dropped == {"listened": 5}
    assert state.listening.report() == {"front": {"listened": 4, "heard_foreign": 2}}
