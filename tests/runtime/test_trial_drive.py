"""A drive in a closed loop: the same seed gives the same bits, and each contact counts as what it is."""

from dataclasses import replace

import numpy as np
import pytest

from echogrid.emulation import plant as plants
from echogrid.emulation.walker import Walker
from echogrid.emulation.world import World
from echogrid.emulation.worlds.arena import Arena
from echogrid.emulation.worlds.arenas import ARENAS
from echogrid.mapping.twist import Twist
from echogrid.runtime.trials import course as courses
from echogrid.runtime.trials.course import GOAL_M, MARGIN_M, course
from echogrid.runtime.trials.drive import Drive
from echogrid.runtime.trials.job import Job
from echogrid.runtime.trials.pilot import STANDING
from echogrid.runtime.trials.pilots import PILOTS
from echogrid.runtime.trials.rigs import RIGS
from echogrid.runtime.trials.troubles import FAULTS

ROOM = ((0.0, 0.0, 9.0, 0.0), (9.0, 0.0, 9.0, 4.0), (9.0, 4.0, 0.0, 4.0), (0.0, 4.0, 0.0, 0.0))
START, GOAL = (0.6, 1.8, 0.9, 2.2), (8.0, 1.8, 8.4, 2.2)


class Ahead:
    """Never looks."""

    guarded = False
    tracker = None

    def __init__(self, robot):
        self.heard = 0

    def hear(self, ping):
        self.heard += 1

    def step(self, now_ns, local, pose, twist, goal):
        return Twist(0.5)


class Held(Ahead):
    """Nor does this one, but somebody looks after it."""

    guarded = True


class Idle(Ahead):
    def step(self, now_ns, local, pose, twist, goal):
        return STANDING


PILOTS_HERE = {**PILOTS, "ahead": Ahead, "held": Held, "idle": Idle}


def room(walls=(), posts=(), walkers=()):
    table = np.array((*ROOM, *walls))
    world = World(
        "room", table, np.zeros(len(table), np.bool_), np.array(posts).reshape(-1, 3), walkers=walkers
    )
    return Arena(world, (1.0, 2.0), (START,), (GOAL,))


@pytest.fixture
def drive_in(monkeypatch):
    """A drive in a room of one's own, eastward along its middle."""

    def made(arena, pilot, **options):
        monkeypatch.setitem(ARENAS, "room", lambda: arena)
        courses.arena_of.cache_clear()
        courses._plan.cache_clear()
        job = Job("room", 1, pilot, **options)
        reach = RIGS[job.rig]().body.reach
        straight = replace(course("room", 1, reach), start=(0.8, 2.0, 0.0))
        monkeypatch.setattr("echogrid.runtime.trials.drive.course", lambda *_: straight)
        return Drive(job, PILOTS_HERE)

    yield made
    courses.arena_of.cache_clear()
    courses._plan.cache_clear()


def test_the_same_seed_gives_the_same_digest_and_another_another():
    def digest(seed):
        return Drive(Job("clutter", seed, "single-scan"), PILOTS).done().digest

    assert digest(0) == digest(0)
    assert digest(0) != digest(2)


def test_a_wall_ahead_without_steering_is_a_collision_counted_once(drive_in):
    verdict = drive_in(room([(5.0, 0.0, 5.0, 3.2)]), "ahead").done()
    assert verdict.outcome == "stuck"
    (bump,) = verdict.bumps
    assert (bump.counts_as, bump.what) == ("collision", "wall")
    assert bump.speed == pytest.approx(0.5)
    assert verdict.failed
    assert verdict.spl == 0.0


def test_who_is_guarded_stands_before_a_wall_whatever_it_asks_for(drive_in):
    verdict = drive_in(room([(5.0, 0.0, 5.0, 3.2)]), "held").done()
    assert verdict.outcome == "stuck"
    assert not verdict.bumps
    assert 0.05 < verdict.least_clearance < 0.4


def test_what_no_ranger_could_hear_is_counted_apart(drive_in):
    verdict = drive_in(room(posts=[(5.0, 2.0, 1e-5)]), "ahead").done()
    (bump,) = verdict.bumps
    assert (bump.counts_as, bump.what) == ("undetectable", "post")
    thicker = drive_in(room(posts=[(5.0, 2.0, 0.02)]), "ahead").done()
    assert [bump.counts_as for bump in thicker.bumps] == ["collision"]


def test_a_deaf_robot_could_hear_nothing(drive_in, monkeypatch):
    monkeypatch.setitem(FAULTS, "deaf", (FAULTS["dead"][0], 0))
    verdict = drive_in(room([(5.0, 0.0, 5.0, 3.2)]), "ahead", fault="deaf").done()
    assert [bump.counts_as for bump in verdict.bumps] == ["undetectable"]
    assert verdict.pings == 0


def test_somebody_long_in_view_is_a_collision_and_who_steps_out_suddenly_is_none(drive_in):
    standing = Walker(((5.0, 2.0), (5.0, 2.001)))
    verdict = drive_in(room(walkers=(standing,)), "ahead").done()
    assert verdict.bumps[0].counts_as == "collision"
    drive = drive_in(room(), "ahead")
    met_s = drive.course.begins_s + 7.0
    way = 0.8 * met_s
    hidden = Walker(((4.0, 2.0 + way), (4.0, 2.0 - way)))
    screens = [(2.9, 2.9, 5.0, 2.9)]
    sudden = drive_in(room(screens, walkers=(hidden,)), "ahead").done()
    assert [bump.what for bump in sudden.bumps][:1] == ["person"]
    assert sudden.bumps[0].counts_as in ("undetectable", "standing")


def test_who_stands_collides_with_nobody(drive_in):
    around = Walker(((6.0, 2.0), (0.8, 2.0)))
    verdict = drive_in(room(walkers=(around,)), "idle").done()
    assert verdict.outcome == "stuck"
    assert {bump.counts_as for bump in verdict.bumps} == {"standing"}


def test_an_open_room_is_crossed_almost_straight(drive_in):
    verdict = drive_in(room(), "blind").done()
    assert verdict.reached
    assert not verdict.bumps
    assert 0.95 < verdict.spl <= 1.0
    assert 1.0 < verdict.time_ratio < 1.4


def test_commands_follow_sounds_within_a_tenth_of_a_second(drive_in):
    verdict = drive_in(room(), "blind").done()
    middle, high = verdict.latency_s
    assert 0.0 < middle <= high < 0.1


@pytest.mark.parametrize(
    ("fault", "told"),
    [("none", 16), ("dead", 14), ("stuck", 16), ("silent", 16), ("dropouts", 16)],
)
def test_faults_take_from_what_is_told(drive_in, fault, told):
    drive = drive_in(room(), "ahead", fault=fault)
    heard = {}
    drive._pilot.hear = lambda ping: heard.setdefault(ping.ranger.name, []).append(
        (ping.reading.outcome, ping.reading.distance)
    )
    for _ in range(400):
        drive._step()
    assert len(heard) == told
    counts = sum(map(len, heard.values()))
    full = 2.0 / 0.14 * told
    assert counts == pytest.approx(full * (0.7 if fault == "dropouts" else 1.0), rel=0.15)
    repeats = [name for name, each in heard.items() if len(set(map(str, each))) == 1]
    assert bool(repeats) or fault != "stuck"


def test_two_dead_rangers_are_neighbours(drive_in):
    drive = drive_in(room(), "ahead", fault="dead")
    for _ in range(100):
        drive._step()
    alive = {ping.seat for ping in drive._pinging.fired}
    first, second = sorted(set(range(16)) - alive)
    assert second - first in (1, 15)


@pytest.mark.parametrize("rig", RIGS)
def test_every_rig_hears_all_around_at_its_pace(drive_in, rig):
    drive = drive_in(room(), "idle", rig=rig)
    for _ in range(400):
        drive._step()
    fired = [ping.seat for ping in drive._pinging.fired]
    assert set(fired) == set(range(len(drive.rig.seats)))
    slowest_ns = max(seat.every_ns for seat in drive.rig.seats)
    assert slowest_ns <= 280_000_000
    assert np.count_nonzero(drive._lookout.local.seen_ns) > 100


def test_crosstalk_changes_what_is_heard(drive_in):
    def told(crosstalk):
        drive = drive_in(room([(3.0, 1.0, 5.0, 1.4)]), "idle", rig="built-in", crosstalk=crosstalk)
        for _ in range(200):
            drive._step()
        return drive.track.digest()

    assert told(True) == told(True) != told(False)


@pytest.mark.parametrize("name", ["clutter", "foyer", "traps", "legs"])
def test_a_task_can_be_done_and_follows_from_its_seed(name):
    reach = RIGS["ring-16"]().body.reach
    for seed in range(3):
        task = course(name, seed, reach)
        assert task == course(name, seed, reach)
        x, y, _ = task.start
        assert task.shortest >= np.hypot(task.goal[0] - x, task.goal[1] - y) - GOAL_M - 1e-9
        clear = task.arena.world.surface_distance(np.array([(x, y), task.goal]))
        assert clear.min() >= reach + MARGIN_M
        people = task.arena.world.at(task.begins_s).people
        assert all(np.hypot(person.x - x, person.y - y) > reach + person.radius for person in people)
    assert course(name, 0, reach) != course(name, 1, reach)


def test_steps_of_pilot_and_plant_fit():
    assert 50_000_000 % plants.STEP_NS == 0
    assert 20_000_000 % plants.STEP_NS == 0
