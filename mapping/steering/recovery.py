"""When every way is blocked: stop, wait, turn to where least stands, leave what is touched or back off,
or give up."""

from dataclasses import dataclass
from enum import Enum
from math import hypot, pi, tau

import numpy as np

from echogrid.mapping.pose import Pose, wrap_angle
from echogrid.mapping.steering.decision import Decision, Why
from echogrid.mapping.steering.limits import Limits, bounded
from echogrid.mapping.steering.obstacles import View
from echogrid.mapping.twist import Twist

_SECOND_NS = 1_000_000_000
_STANDING = 0.01
"""m/s: slower than that the robot stands."""


class Stage(Enum):
    """What recovery is about."""

    NONE = "there is a way"
    STOP = "stopping"
    WAIT = "waiting for what is in the way to go"
    TURN = "turning to where least stands"
    AHEAD = "leaving what it touches"
    BACK = "backing off over what was seen free"
    STUCK = "stuck: it needs help, or a way that opens by itself"


@dataclass(frozen=True, slots=True)
class Patience:
    """How much is tried."""

    stop_ns: int = 2 * _SECOND_NS
    """At the longest; then it is taken to stand."""
    wait_ns: int = 2 * _SECOND_NS
    turn_ns: int = 8 * _SECOND_NS
    """At the longest."""
    held_ns: int = _SECOND_NS // 2
    """Who does not turn for so long, as its motors are not asked to, may not."""
    aligned: float = 0.1
    """rad."""
    back_speed: float = 0.1
    """m/s; ahead, too."""
    back: float = 0.3
    """m, at the most, each time."""
    back_ns: int = 6 * _SECOND_NS
    """At the longest."""
    room: float = 0.15
    """m that must be free behind, or clear ahead, beyond where the robot can stop."""
    attempts: int = 3
    """So often it turns and backs off without getting on; then it is stuck."""
    most_ns: int = 60 * _SECOND_NS
    """After so long without getting on it is stuck, too."""
    progress: float = 1.0
    """m from where it was first blocked: then it has got on."""
    calm_ns: int = 10 * _SECOND_NS
    """If there was a way for so long, what was before is forgotten, too."""


class Recovery:
    """A machine of a few stages. Time is what it is told; it ends in NONE or in STUCK."""

    def __init__(self, limits: Limits, patience: Patience | None = None) -> None:
        self.stage = Stage.NONE
        self.attempts = 0
        """Begun since the robot last got on."""
        self._limits = limits
        self._patience = patience or Patience()
        self._since_ns = 0
        self._aim = 0.0
        self._from = Pose()
        self._blocked_ns: int | None = None
        self._blocked_at = Pose()

    def wish(self, now_ns: int, view: View, decision: Decision, now: Twist) -> Twist | None:
        """The twist to come to, for a robot that drives `now`; None if there is a way."""
        if decision.heading is not None:
            if self.stage is not Stage.NONE:
                self._enter(Stage.NONE, now_ns, view)
            return None
        if self.stage is Stage.NONE:
            self._begin(now_ns, view)
        self._advance(now_ns, view, decision, now)
        return self._twist(view)

    def _begin(self, now_ns: int, view: View) -> None:
        """A way is closed: it is another trouble than the last one if the robot got on since, or was calm."""
        got_on = _way(self._blocked_at, view.robot) >= self._patience.progress
        if self._blocked_ns is None or got_on or now_ns - self._since_ns >= self._patience.calm_ns:
            self._blocked_ns, self._blocked_at, self.attempts = now_ns, view.robot, 0
        self._enter(Stage.STOP, now_ns, view)

    def _advance(self, now_ns: int, view: View, decision: Decision, now: Twist) -> None:
        """Go on to the next stage, if this one is over."""
        patience, elapsed_ns = self._patience, now_ns - self._since_ns
        if self.stage is Stage.STOP and (abs(now.speed) < _STANDING or elapsed_ns >= patience.stop_ns):
            self._enter(Stage.WAIT, now_ns, view)
        elif self.stage is Stage.WAIT and elapsed_ns >= patience.wait_ns:
            self._try(now_ns, view, decision)
        elif self.stage is Stage.TURN and (self._aligned(view) or self._turned(elapsed_ns, now)):
            touches = decision.why is Why.TOUCHING and self._is_clear(view, now)
            self._enter(Stage.AHEAD if touches else Stage.BACK, now_ns, view)
        leaves = self.stage is Stage.AHEAD and not (self._goes_on(now_ns, view) and self._is_clear(view, now))
        backs = self.stage is Stage.BACK and not (self._goes_on(now_ns, view) and self._is_free(view, now))
        if leaves or backs:
            self._enter(Stage.STOP, now_ns, view)

    def _try(self, now_ns: int, view: View, decision: Decision) -> None:
        late = self._blocked_ns is not None and now_ns - self._blocked_ns >= self._patience.most_ns
        if late or self.attempts >= self._patience.attempts:
            self._enter(Stage.STUCK, now_ns, view)
            return
        self.attempts += 1
        self._aim = least_blocked(view, decision)
        self._enter(Stage.TURN, now_ns, view)

    def _enter(self, stage: Stage, now_ns: int, view: View) -> None:
        self.stage, self._since_ns, self._from = stage, now_ns, view.robot

    def _aligned(self, view: View) -> bool:
        return abs(wrap_angle(self._aim - view.robot.yaw)) <= self._patience.aligned

    def _turned(self, elapsed_ns: int, now: Twist) -> bool:
        """Whether it turned for long enough, or may not turn at all."""
        held = elapsed_ns >= self._patience.held_ns and now.stands
        return held or elapsed_ns >= self._patience.turn_ns

    def _goes_on(self, now_ns: int, view: View) -> bool:
        """Whether it is neither far nor long enough yet."""
        patience = self._patience
        return _way(self._from, view.robot) < patience.back and now_ns - self._since_ns < patience.back_ns

    def _is_free(self, view: View, now: Twist) -> bool:
        """Whether all behind, as far as it may roll, was seen free."""
        return view.free(view.robot.yaw + pi, self._needed(now))

    def _is_clear(self, view: View, now: Twist) -> bool:
        """Whether nothing is ahead as far as it may roll: what touches it is beside or behind."""
        return view.clearance(view.robot.yaw) >= self._needed(now)

    def _needed(self, now: Twist) -> float:
        """m."""
        fastest = max(self._patience.back_speed, abs(now.speed))
        return self._patience.room + fastest**2 / (2.0 * self._limits.acceleration)

    def _twist(self, view: View) -> Twist:
        if self.stage is Stage.TURN:
            turn = wrap_angle(self._aim - view.robot.yaw)
            return Twist(0.0, bounded(2.0 * turn, self._limits.turn_rate / 2.0))
        if self.stage in (Stage.AHEAD, Stage.BACK):
            speed = min(self._patience.back_speed, self._limits.speed)
            return Twist(speed if self.stage is Stage.AHEAD else -speed)
        return Twist()


def least_blocked(view: View, decision: Decision) -> float:
    """rad, in the grid's frame: of the directions with the least density the nearest to the robot's own."""
    n = view.window.sectors
    density = np.where(view.shut, np.inf, decision.polar.density)
    turns = [wrap_angle(k * tau / n - view.robot.yaw) for k in np.flatnonzero(density == density.min())]
    return wrap_angle(view.robot.yaw + min(turns, key=abs))


def _way(start: Pose, end: Pose) -> float:
    return hypot(end.x - start.x, end.y - start.y)
