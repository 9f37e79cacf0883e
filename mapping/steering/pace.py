"""From a heading to a twist: as fast as the robot can stop within what it sees, and slower while it turns."""

from dataclasses import dataclass
from math import radians, sqrt

from echogrid.mapping.pose import wrap_angle
from echogrid.mapping.steering.decision import Decision
from echogrid.mapping.steering.limits import Limits, bounded
from echogrid.mapping.steering.obstacles import View
from echogrid.mapping.twist import Twist


@dataclass(frozen=True, slots=True)
class Manner:
    """How a heading is followed."""

    gain: float = 2.0
    """K_s, 1/s: Omega = K_s (delta - theta)."""
    latency_s: float = 0.25
    """From an obstacle's echo to the wheels."""
    creep: float = 0.05
    """m/s: V_min, where there is room for it."""
    turn_from: float = radians(60.0)
    """If the heading is farther off, the robot turns in place..."""
    turn_until: float = radians(35.0)
    """...until it is no farther off than this."""


class Pace:
    """Remembers whether it turns in place."""

    def __init__(self, limits: Limits, manner: Manner | None = None) -> None:
        self._limits = limits
        self._manner = manner or Manner()
        self._turning = False

    def wish(self, view: View, decision: Decision) -> Twist:
        """The twist to come to, zero without a heading; what the robot can reach of it says `Limits.reach`.

        V = V_max (1 - (Omega/Omega_max)^2), with what the method grants (Borenstein & Koren 1991 slow down
        linearly: a heading 20 deg off then costs half the speed),
        and no faster than the robot can stop in what is free on its way and on the heading.
        """
        if decision.heading is None:
            self._turning = False
            return Twist()
        turn = wrap_angle(decision.heading - view.robot.yaw)
        self._turning = abs(turn) > (self._manner.turn_until if self._turning else self._manner.turn_from)
        rate = bounded(self._manner.gain * turn, self._limits.turn_rate)
        if self._turning:
            return Twist(0.0, rate)
        full = self._limits.speed * decision.factor * (1.0 - (rate / self._limits.turn_rate) ** 2)
        safe = self.stoppable(self._room(view, decision, decision.heading))
        return Twist(min(max(full, self._manner.creep), safe, self._limits.speed), rate)

    def stoppable(self, room: float) -> float:
        """The speed v (m/s) from which the robot stops in that room (m): v t + v^2/2a = room."""
        a, t = self._limits.acceleration, self._manner.latency_s
        return sqrt((a * t) ** 2 + 2.0 * a * max(room, 0.0)) - a * t

    def _room(self, view: View, decision: Decision, heading: float) -> float:
        clear = min(view.clearance(heading), view.clearance(view.robot.yaw))
        return min(clear - view.window.body.margin, decision.goal.distance)
