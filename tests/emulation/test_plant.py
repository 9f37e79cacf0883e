"""What the robot's body does when it is told to, and when something is in its way."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from echogrid.emulation.body import Disc, Hull
from echogrid.emulation.plant import STEP_NS, Drive, Encoders, Plant, Touched
from echogrid.emulation.vista import Post
from echogrid.emulation.walker import Walker
from echogrid.emulation.world import World

FAR_WALL = (3.0, -5.0, 3.0, 5.0)
SECOND = 1_000_000_000 // STEP_NS
DRIVE = Drive()
BODIES = [Disc(0.2), Hull(((0.2, -0.15), (0.2, 0.15), (-0.2, 0.15), (-0.2, -0.15)))]


def world_of(wall=FAR_WALL, walkers=()):
    return World("bare", np.array([wall]), np.zeros(1, np.bool_), np.empty((0, 3)), walkers=walkers)


def plant_in(world, start=(0.0, 0.0, 0.0), body=BODIES[0], drive=DRIVE):
    return Plant(world, body, drive, start, lambda at_ns: world.at(at_ns * 1e-9).people)


def run(plant, seconds):
    for _ in range(round(seconds * SECOND)):
        plant.step()


def test_a_command_counts_after_its_latency():
    plant = plant_in(world_of(), drive=Drive(latency_ns=100_000_000))
    plant.ask(0.5, 0.0)
    run(plant, 0.1)
    assert plant.speed == 0.0
    plant.step()
    assert plant.speed > 0.0


@given(st.floats(-2.0, 2.0), st.floats(-5.0, 5.0))
def test_nothing_exceeds_the_limits_of_the_motors(speed, turn_rate):
    plant = plant_in(world_of(), (-50.0, 0.0, 0.0))
    drive, before = plant.drive, (0.0, 0.0)
    plant.ask(speed, turn_rate)
    for _ in range(SECOND):
        plant.step()
        assert abs(plant.speed) <= drive.speed
        assert abs(plant.turn_rate) <= drive.turn_rate
        assert abs(plant.speed - before[0]) <= drive.acceleration * STEP_NS * 1e-9 + 1e-12
        assert abs(plant.turn_rate - before[1]) <= drive.turn_acceleration * STEP_NS * 1e-9 + 1e-12
        before = plant.speed, plant.turn_rate


def test_it_stops_within_its_stopping_distance():
    plant = plant_in(world_of(), (-50.0, 0.0, 0.0))
    plant.ask(0.5, 0.0)
    run(plant, 3.0)
    before = plant.travelled
    plant.ask(0.0, 0.0)
    run(plant, 3.0)
    assert plant.speed == 0.0
    assert plant.travelled - before == pytest.approx(plant.drive.stopping_distance(0.5), abs=0.003)


@pytest.mark.parametrize("body", BODIES)
def test_it_does_not_pass_through_a_wall_and_touches_it_once(body):
    plant = plant_in(world_of(), body=body)
    plant.ask(0.5, 0.0)
    run(plant, 15.0)
    assert plant.pose[0] == pytest.approx(2.8, abs=0.003)
    (contact,) = plant.contacts
    assert contact.touched == Touched("wall", 0)
    assert contact.speed == pytest.approx(0.5)
    assert plant.gaps().least > 0.0


def test_it_may_leave_what_it_touches_and_touch_it_again():
    plant = plant_in(world_of())
    for speed, seconds in ((0.5, 8.0), (-0.5, 3.0), (0.5, 8.0)):
        plant.ask(speed, 0.0)
        run(plant, seconds)
    assert len(plant.contacts) == 2


def test_the_wheels_stand_while_it_is_held():
    plant = plant_in(world_of())
    plant.ask(0.5, 0.0)
    run(plant, 12.0)
    held = plant.wheels
    run(plant, 1.0)
    assert plant.wheels == held


def test_somebody_who_walks_into_a_robot_that_stands_touches_it_at_no_speed():
    world = world_of(walkers=(Walker(((2.0, 0.0), (-2.0, 0.0))),))
    plant = plant_in(world)
    run(plant, 4.0)
    (contact,) = plant.contacts
    assert contact.touched == Touched("person", 0)
    assert contact.speed == 0.0
    assert plant.pose == (0.0, 0.0, 0.0)


def test_who_is_overlapped_by_somebody_may_go_away_from_them():
    somebody = Post(0.3, 0.0, 0.22, 12.0)
    plant = replace_people(plant_in(world_of(), (0.0, 0.0, 0.0)), somebody)
    plant.ask(0.3, 0.0)
    run(plant, 1.0)
    assert plant.travelled == 0.0
    plant.ask(-0.3, 0.0)
    run(plant, 1.0)
    assert plant.pose[0] < -0.1


def replace_people(plant, somebody):
    return Plant(plant.world, plant.body, plant.drive, plant.start, lambda _: (somebody,))


def test_poses_between_steps_lie_between_them():
    plant = plant_in(world_of())
    plant.ask(0.4, 0.0)
    run(plant, 2.0)
    at_ns = 300 * STEP_NS
    before, after = plant.pose_at(at_ns), plant.pose_at(at_ns + STEP_NS)
    assert plant.pose_at(at_ns + STEP_NS // 2)[0] == pytest.approx(0.5 * (before[0] + after[0]))
    assert plant.pose_at(-1) == plant.start
    assert plant.pose_at(10**12) == plant.pose


def test_it_knows_when_it_had_gone_so_far():
    plant = plant_in(world_of())
    plant.ask(0.5, 0.0)
    run(plant, 5.0)
    at_ns = plant.when_travelled(1.0)
    assert plant.pose_at(at_ns)[0] == pytest.approx(1.0, abs=0.003)


def test_encoders_without_errors_are_the_wheels():
    encoders = Encoders(1, scale_error=0.0, difference=0.0, slip=0.0)
    for turned in (0.5, 2.0, 1.0):
        assert encoders.read((turned, -turned)) == pytest.approx((turned, -turned))


def test_the_same_seed_slips_alike_and_another_otherwise():
    def told(seed):
        encoders = Encoders(seed)
        return [encoders.read((0.1 * step, 0.1 * step)) for step in range(50)]

    assert told(1) == told(1)
    assert told(1) != told(2)
    assert told(1)[-1] == pytest.approx((4.9, 4.9), rel=0.05)


def test_a_slower_drive_needs_less_room():
    assert Drive().stopping_distance(0.5) == pytest.approx(0.18125)
    assert replace(Drive(), acceleration=1.0).stopping_distance(0.5) == pytest.approx(0.15)
