from collections.abc import Iterator
from dataclasses import replace
from math import cos, hypot, inf, pi, sin, tau

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.pose import Pose, wrap_angle
from echogrid.mapping.steering.decision import Decision, Polar, Why
from echogrid.mapping.steering.goal import Goal
from echogrid.mapping.steering.limits import Limits
from echogrid.mapping.steering.obstacles import Obstacles, View
from echogrid.mapping.steering.recovery import Patience, Recovery, Stage, least_blocked
from echogrid.mapping.twist import Twist

from .scenes import BODY, LIMITS, MIDDLE, NOW, RESOLUTION, WINDOW, facing, headings, local_grid, view_of

SECOND = 1_000_000_000
STEP_S = 0.05
STEP = 50_000_000
PATIENCE = Patience()
LONGEST_S = 60.0 + 3.0 * 18.0
"""More than all stages of all attempts can take."""

densities = st.lists(st.floats(0.0, 9.0), min_size=72, max_size=72)


def blocked(density: list[float] | None = None) -> Decision:
    none = np.zeros(72, np.bool_)
    polar = Polar(np.array(density or [1.0] * 72), 0.5, 0.5, ~none, none)
    return Decision(None, 0.0, Why.BLOCKED, Goal(0.0), polar)


OPEN = replace(blocked(), heading=0.0, factor=1.0, why=Why.TARGET)


class Drive:
    """A robot in a grid that stays as it is, with recovery alone at the wheel."""

    def __init__(
        self, local: LocalGrid, yaw: float = 0.0, speed: float = 0.0, recovery: Recovery | None = None
    ):
        self.recovery = Recovery(LIMITS) if recovery is None else recovery
        self.robot, self.twist, self.now_ns = facing(yaw), Twist(speed), NOW
        self._local, self._obstacles = local, Obstacles(WINDOW)

    def view(self) -> View:
        self._local.centre(self.robot)
        return self._obstacles.view(self._local, self.robot, self.now_ns)

    def step(self, decision: Decision) -> Twist | None:
        """Ask, and obey within the limits."""
        wish = self.recovery.wish(self.now_ns, self.view(), decision, self.twist)
        self.twist = LIMITS.reach(wish or Twist(), self.twist, STEP_S)
        self.robot = self.robot.compose(Pose(self.twist.speed * STEP_S, 0.0, self.twist.turn_rate * STEP_S))
        self.now_ns += STEP
        return wish

    def run(self, decision: Decision, seconds: float) -> Iterator[Stage]:
        for _ in range(round(seconds / STEP_S)):
            self.step(decision)
            yield self.recovery.stage


def unseen_beneath(local: LocalGrid, robot: Pose, start: Pose) -> int:
    """How many cells wholly within the robot were never seen free, but for those beneath it at the start."""
    geometry = local.geometry
    x, y = geometry.x_centres[np.newaxis, :], geometry.y_centres[:, np.newaxis]
    beneath = np.hypot(x - robot.x, y - robot.y) <= BODY.radius
    before = np.hypot(x - start.x, y - start.y) <= BODY.radius + RESOLUTION
    return int((beneath & ~before & ((local.seen_ns == 0) | (local.grid.log_odds >= 0))).sum())


@st.composite
def patchy(draw: st.DrawFn) -> LocalGrid:
    """Free, but for what is not known or occupied, here and there."""
    local = local_grid([])
    rng = np.random.default_rng(draw(st.integers(0, 1 << 32)))
    part = draw(st.sampled_from([0.0, 0.01, 0.05, 0.3, 1.0]))
    local.seen_ns[rng.random(local.seen_ns.shape) < part] = 0
    local.grid.log_odds[rng.random(local.seen_ns.shape) < part / 2.0] = 2000
    return local


@settings(max_examples=20)
@given(patchy(), headings, densities, st.floats(0.0, 0.5))
def test_it_never_backs_onto_what_was_not_seen_free(
    local: LocalGrid, yaw: float, density: list[float], speed: float
) -> None:
    drive, decision = Drive(local, yaw), blocked(density)
    start = drive.robot
    for _ in range(round(40.0 / STEP_S)):
        before = drive.robot
        drive.step(decision)
        ahead = (drive.robot.x - before.x) * cos(before.yaw) + (drive.robot.y - before.y) * sin(before.yaw)
        if ahead < -1e-12:
            assert unseen_beneath(local, drive.robot, start) == 0


@settings(max_examples=20)
@given(patchy(), headings, densities, st.floats(0.0, 0.5))
def test_a_robot_that_stays_shut_in_is_stuck_in_bounded_time_and_not_far_away(
    local: LocalGrid, yaw: float, density: list[float], speed: float
) -> None:
    drive = Drive(local, yaw, speed)
    start = drive.robot
    stages = list(drive.run(blocked(density), LONGEST_S))
    assert stages[-1] is Stage.STUCK
    assert drive.twist == Twist()
    assert drive.recovery.attempts <= PATIENCE.attempts
    rolled = speed**2 / (2.0 * LIMITS.acceleration) + speed * STEP_S
    backed = PATIENCE.attempts * (PATIENCE.back + 0.05)
    assert hypot(drive.robot.x - start.x, drive.robot.y - start.y) <= rolled + backed


@settings(max_examples=20)
@given(patchy(), headings, st.lists(st.tuples(st.booleans(), st.floats(0.05, 5.0)), max_size=8))
def test_no_wish_is_beyond_the_limits_and_none_drives_forward(
    local: LocalGrid, yaw: float, spells: list[tuple[bool, float]]
) -> None:
    drive = Drive(local, yaw)
    for is_open, seconds in spells:
        for _ in range(round(seconds / STEP_S)):
            wish = drive.step(OPEN if is_open else blocked())
            assert (wish is None) == is_open
            if wish is not None:
                assert -LIMITS.speed <= wish.speed <= 0.0
                assert abs(wish.turn_rate) <= LIMITS.turn_rate


def test_in_the_open_it_stops_waits_turns_and_backs_off_three_times_before_it_is_stuck() -> None:
    density = [1.0] * 72
    density[30] = 0.0
    stages = list(Drive(local_grid([]), speed=0.3).run(blocked(density), LONGEST_S))
    changes = [stage for stage, before in zip(stages, [None, *stages], strict=False) if stage is not before]
    attempt = [Stage.STOP, Stage.WAIT, Stage.TURN, Stage.BACK]
    again = [Stage.STOP, Stage.WAIT, Stage.BACK]
    rest = [stage for stage in changes[4:] if stage is not Stage.TURN]
    assert changes[:4] == attempt
    assert rest == [*again, *again, Stage.STOP, Stage.WAIT, Stage.STUCK]


def test_it_turns_to_where_least_stands() -> None:
    density = [1.0] * 72
    density[20] = 0.5
    drive = Drive(local_grid([]))
    for stage in drive.run(blocked(density), 20.0):
        if stage is Stage.BACK:
            break
    assert abs(wrap_angle(drive.robot.yaw - 20 * tau / 72.0)) <= PATIENCE.aligned + 0.08


@given(densities, headings)
def test_of_equal_directions_the_nearest_is_least_blocked(density: list[float], yaw: float) -> None:
    least = least_blocked(view_of([], facing(yaw)), blocked(density))
    turns = [abs(wrap_angle(k * tau / 72.0 - yaw)) for k in range(72) if density[k] == min(density)]
    assert abs(wrap_angle(least - yaw)) == approx(min(turns), abs=1e-9)


def test_a_direction_of_which_nothing_is_known_is_not_the_least_blocked() -> None:
    view = view_of([])
    shut = view.shut.copy()
    shut[1:71] = True
    assert least_blocked(replace(view, shut=shut), blocked([5.0] + [0.0] * 70 + [1.0])) == approx(-tau / 72.0)


def test_nothing_is_wished_while_there_is_a_way() -> None:
    drive = Drive(local_grid([]))
    assert drive.step(OPEN) is None
    assert drive.recovery.stage is Stage.NONE


@given(st.floats(0.1, LONGEST_S))
@settings(max_examples=20)
def test_a_way_that_opens_is_taken_at_once_from_any_stage(seconds: float) -> None:
    drive = Drive(local_grid([]))
    for _ in drive.run(blocked(), seconds):
        pass
    assert drive.step(OPEN) is None
    assert drive.recovery.stage is Stage.NONE


def test_a_way_that_opens_and_shuts_again_on_the_spot_ends_in_being_stuck() -> None:
    drive = Drive(local_grid([]))
    stages = set()
    for _ in range(30):
        stages |= {*drive.run(blocked(), 2.9), *drive.run(OPEN, 0.3)}
        stages |= {*drive.run(blocked(), 1.0)}
    assert Stage.STUCK in stages


@pytest.mark.parametrize(("away", "calm_s"), [(1.1, 0.5), (0.0, 10.5)])
def test_a_robot_that_got_on_or_was_calm_begins_anew(away: float, calm_s: float) -> None:
    drive = Drive(local_grid([], cells=100))
    for _ in drive.run(blocked(), LONGEST_S):
        pass
    assert drive.recovery.stage is Stage.STUCK
    drive.robot = replace(drive.robot, x=drive.robot.x + away)
    assert list(drive.run(OPEN, calm_s))[-1] is Stage.NONE
    assert Stage.STUCK not in set(drive.run(blocked(), 5.0))


def test_a_robot_that_does_not_turn_as_it_is_told_gives_up_after_a_while() -> None:
    recovery, view, now_ns = Recovery(LIMITS), view_of([], facing(2.0)), NOW
    stages = []
    while now_ns < NOW + 200 * SECOND:
        recovery.wish(now_ns, view, blocked([0.0] + [1.0] * 71), Twist(0.3, 0.5))
        stages.append(recovery.stage)
        now_ns += STEP
    assert stages[-1] is Stage.STUCK


def test_who_may_not_turn_goes_on_at_once() -> None:
    recovery, view, now_ns = Recovery(LIMITS), view_of([], facing(2.0)), NOW
    stages = []
    while now_ns < NOW + 4 * SECOND:
        recovery.wish(now_ns, view, blocked([0.0] + [1.0] * 71), Twist())
        stages.append(recovery.stage)
        now_ns += STEP
    assert stages.count(Stage.TURN) == PATIENCE.held_ns // STEP
    assert stages[-1] is Stage.BACK


@pytest.mark.parametrize("cell", [(0, -1), (1, -1), (-1, -1)])
def test_what_is_touched_from_behind_is_left_ahead(cell: tuple[int, int]) -> None:
    drive = Drive(local_grid([(*cell, 2000)]))
    assert drive.view().touching
    touching = replace(blocked([0.0] + [1.0] * 71), why=Why.TOUCHING)
    for stage in drive.run(touching, LONGEST_S):
        if drive.twist.speed > 0.0:
            assert stage is Stage.AHEAD
        if not drive.view().touching:
            break
    assert not drive.view().touching
    assert drive.robot.x > MIDDLE.x


@settings(max_examples=20)
@given(patchy(), headings, densities)
def test_it_goes_ahead_only_where_nothing_is_and_only_from_what_it_touches(
    local: LocalGrid, yaw: float, density: list[float]
) -> None:
    drive = Drive(local, yaw)
    touching = replace(blocked(density), why=Why.TOUCHING)
    for _ in range(round(40.0 / STEP_S)):
        wish = drive.step(touching)
        if wish is not None and wish.speed > 0.0:
            assert drive.view().clearance(drive.robot.yaw) >= PATIENCE.room - 0.01


def test_a_slow_robot_backs_off_no_faster_than_it_may() -> None:
    recovery = Recovery(Limits(speed=0.02))
    view = view_of([], MIDDLE)
    wishes = [recovery.wish(NOW + step * STEP, view, blocked(), Twist()) for step in range(400)]
    speeds = {wish.speed for wish in wishes if wish is not None}
    assert min(speeds, default=inf) == -0.02


def test_with_the_unseen_behind_it_stays_where_it_is() -> None:
    local = local_grid([])
    local.seen_ns[:, :18] = 0
    drive = Drive(local)
    for _ in drive.run(blocked([0.0] + [1.0] * 71), LONGEST_S):
        pass
    assert drive.robot.x == approx(MIDDLE.x)
    assert abs(drive.robot.yaw) < pi
