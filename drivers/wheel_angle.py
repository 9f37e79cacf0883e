"""A wheel's angle, kept continuous over restarts and jumps of the controller that counts it."""

from dataclasses import dataclass
from math import tau

from echogrid.drivers.role import Steering

SLACK_S = 0.020
"""Two cycles of a controller: frames read late in one go are stamped closer together than they were sent."""
COARSENESS = 2.0**-22
"""Two steps of the float32 in which many controllers send their count, relative to it."""
RESTART_TURNS = 0.25
"""A restarted controller counts from zero; so far it may have turned until it is heard."""


@dataclass(frozen=True, slots=True)
class _Count:
    stamp_ns: int
    turns: float
    rate: float


class WheelAngle:
    """Turns of the encoder -> rad of the wheel, in float64. Starts at the angle that is reported.

    An angle of steering is never re-baselined: whatever was before, it is what is reported.
    """

    def __init__(
        self,
        gear: float,
        fastest: float,
        steering: Steering | None = None,
        coarseness: float = COARSENESS,
    ) -> None:
        """`coarseness` is that of the turns, relative to them; 0 where they are counted."""
        self._radians_per_turn = tau / gear
        self._fastest = fastest * abs(gear) / tau
        self._steering = steering
        self._coarseness = coarseness
        self._zero = steering.zero / self._radians_per_turn if steering else 0.0
        self._last: _Count | None = None
        self._doubted: _Count | None = None

    def advance(
        self, stamp_ns: int, turns: float, rate: float, gap: bool = False, restarted: bool = False
    ) -> tuple[float, bool] | None:
        """The angle at these turns (their rate in turns/s), and whether it was re-baselined with zero motion;
        of steering, whether nobody knows how it turned since the last call.

        `restarted`: the controller has zeroed its count since the last call. `gap`: it may have.
        None: the wheel cannot have turned so far; the next call tells whether it was a jump or an error.
        """
        count, last, doubted = _Count(stamp_ns, turns, rate), self._last, self._doubted
        self._doubted = None
        jumped = last is not None and (restarted or (gap and _looks_restarted(last, count)))
        if last is not None and not jumped and not self._possible(last, count):
            if doubted is None or not self._possible(doubted, count):
                self._doubted = count
                return None
            jumped = True
        if last is not None and jumped and self._steering is None:
            self._zero += turns - last.turns
        self._last = count
        return (turns - self._zero) * self._radians_per_turn, jumped

    def rate(self, rate: float) -> float:
        """rad/s of the wheel for turns/s of the encoder."""
        return rate * self._radians_per_turn

    def believable(self, turns: float, rate: float) -> bool:
        """Whether an encoder could have sent this: finer than whole turns, at a rate near the possible."""
        return abs(turns) < 1 << 23 and self.reaches(turns) and self.keeps_up(rate)

    def keeps_up(self, rate: float) -> bool:
        """Whether the rate (turns/s) is near the possible."""
        return abs(rate) <= 2 * self._fastest

    def reaches(self, turns: float) -> bool:
        """Whether it can stand there: a wheel can anywhere, steering only so far from straight ahead."""
        if self._steering is None:
            return True
        return abs((turns - self._zero) * self._radians_per_turn) <= self._steering.most

    def precedes(self, stamp_ns: int) -> bool:
        """Whether the last count is not newer than this."""
        return self._last is None or self._last.stamp_ns <= stamp_ns

    def _possible(self, last: _Count, count: _Count) -> bool:
        most = self._fastest * (_seconds(last, count) + SLACK_S) + abs(count.turns) * self._coarseness
        return abs(count.turns - last.turns) <= most


def _looks_restarted(last: _Count, count: _Count) -> bool:
    """Whether the count is at about zero, and not on the way on which the wheel was."""
    start, end = sorted((last.turns, last.turns + last.rate * _seconds(last, count)))
    on_the_way = start - 2 * RESTART_TURNS <= count.turns <= end + 2 * RESTART_TURNS
    return abs(count.turns) < RESTART_TURNS and not on_the_way


def _seconds(last: _Count, count: _Count) -> float:
    return (count.stamp_ns - last.stamp_ns) * 1e-9
