"""What a wheel shall do: asked for by whoever drives the robot, looked at by the thread of its bus."""

from echogrid.drivers.limits import clipped

FRESH_NS = 200_000_000
"""A rate that nobody has asked for anew in so long is none: the wheel shall stand."""


class Throttle:
    """Until a rate is asked for there is none, and nothing is to be sent that could enable a motor."""

    def __init__(self, most: float, acceleration: float) -> None:
        """`most` is the highest rate, rad/s of the wheel; `acceleration` how fast it may rise, rad/s^2."""
        self.acceleration = acceleration
        self.obeyed = False
        """Whether the motor is enabled, and turns as it is asked to. Written by the bus's thread."""
        self._most = most
        self._asked: tuple[int, float] | None = None
        self._lapsed = False

    def ask(self, now_ns: int, rate: float) -> None:
        """Ask for a rate, rad/s of the wheel, positive ahead; to be repeated while it shall last.

        Whoever paused for longer than a rate is fresh must ask for zero before the wheel turns again: what
        was wanted before the pause may be wrong after it.
        """
        paused = self._asked is not None and now_ns - self._asked[0] > FRESH_NS
        self._lapsed = rate != 0.0 and (self._lapsed or paused)
        self._asked = now_ns, 0.0 if self._lapsed else clipped(rate, self._most)

    def release(self) -> None:
        """Ask for nothing any more: the motor shall be let go."""
        self._asked, self._lapsed = None, False

    def stands(self, now_ns: int) -> bool:
        """Whether it is asked, freshly, to stand."""
        asked = self._asked
        return asked is not None and asked[1] == 0.0 and now_ns - asked[0] <= FRESH_NS

    def rate(self, now_ns: int) -> float | None:
        """The rate, rad/s; 0 if it is no longer fresh; None if nothing is asked for."""
        asked = self._asked  # another thread may ask at any time
        if asked is None:
            return None
        return asked[1] if now_ns - asked[0] <= FRESH_NS else 0.0
