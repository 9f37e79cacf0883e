"""A wheel's axle: a controller's encoder looks at it, and its motor may turn it."""

from collections.abc import Callable
from math import copysign


class Shaft:
    """Turned by somebody else, as on a robot that drives a prescribed tour: a motor has no effect on it."""

    def __init__(self, angle: Callable[[int], float]) -> None:
        self._angle = angle

    @classmethod
    def of(cls, angle: Callable[[int], float]) -> "Shaft":
        """That shaft, or one with that angle."""
        return angle if isinstance(angle, Shaft) else cls(angle)

    def __call__(self, now_ns: int) -> float:
        """Its angle, rad of the wheel."""
        return self._angle(now_ns)

    def drive(self, rate: float, now_ns: int) -> None:
        """The motor holds it at that rate (rad/s of the wheel) from now on."""

    def release(self, now_ns: int) -> None:
        """The motor lets it roll."""


class MotorShaft(Shaft):
    """Turned by its motor alone, which speeds up and slows down evenly; let go, it rolls to a stop.

    Its angle may be asked for at any time, also before the latest command.
    """

    def __init__(self, acceleration: float = 60.0, friction: float = 15.0) -> None:
        """Both in rad/s^2: what the motor can do, and how it slows down by itself."""
        super().__init__(self._followed)
        self._acceleration = acceleration
        self._friction = friction
        self._strokes = [_Stroke(0, 0.0, 0.0, 0.0, friction)]
        self.changed: Callable[[int], None] = lambda _: None
        """Called with the time from which on its way is another than it was."""

    def drive(self, rate: float, now_ns: int) -> None:
        """The motor holds it at that rate from now on."""
        self._change(now_ns, rate, self._acceleration)

    def release(self, now_ns: int) -> None:
        """The motor lets it roll."""
        self._change(now_ns, 0.0, self._friction)

    def rate(self, now_ns: int) -> float:
        """rad/s."""
        return self._stroke(now_ns).at(now_ns)[1]

    def _change(self, now_ns: int, target: float, acceleration: float) -> None:
        last = self._strokes[-1]
        if (last.target, last.acceleration) != (target, acceleration):
            angle, rate = self._stroke(now_ns).at(now_ns)
            self._strokes.append(_Stroke(now_ns, angle, rate, target, acceleration))
            del self._strokes[:-64]
            self.changed(now_ns)

    def _followed(self, now_ns: int) -> float:
        return self._stroke(now_ns).at(now_ns)[0]

    def _stroke(self, now_ns: int) -> "_Stroke":
        """The one that holds then; of what is long past the oldest that is kept."""
        return next((each for each in reversed(self._strokes) if each.start_ns <= now_ns), self._strokes[0])


class _Stroke:
    """From a rate evenly to a target, and on at that."""

    def __init__(self, start_ns: int, angle: float, rate: float, target: float, acceleration: float) -> None:
        self.start_ns = start_ns
        self.target = target
        self.acceleration = acceleration
        self._angle = angle
        self._rate = rate

    def at(self, now_ns: int) -> tuple[float, float]:
        """Angle and rate."""
        seconds = (now_ns - self.start_ns) * 1e-9
        ramp = abs(self.target - self._rate) / self.acceleration
        change = copysign(self.acceleration, self.target - self._rate)
        if seconds < ramp:
            return self._angle + (
                self._rate + 0.5 * change * seconds
            ) * seconds, self._rate + change * seconds
        reached = self._angle + 0.5 * (self._rate + self.target) * ramp
        return reached + self.target * (seconds - ramp), self.target
