"""A motor that is told its rate: enabled at rest only, sped up gently, let go at the end."""

from collections.abc import Sequence
from math import copysign
from typing import Generic, Protocol, TypeVar

from echogrid.drivers.bus import NEVER_NS
from echogrid.drivers.throttle import Throttle

Out = TypeVar("Out")
Out_co = TypeVar("Out_co", covariant=True)

PERIOD_NS = 20_000_000
"""From rate to rate."""
PERIOD_S = PERIOD_NS * 1e-9
AGAIN_NS = 100_000_000
"""From one attempt to enable it to the next."""


class Commands(Protocol[Out_co]):
    """A make's messages; each returns what is to be sent now."""

    def enable(self) -> Sequence[Out_co]:
        """What brings it nearer to being driven, from whatever state it is in; its rate is zero then."""
        ...

    def drive(self, rate: float) -> Sequence[Out_co]:
        """Turn the wheel at that rate, rad/s."""
        ...

    def let_go(self) -> Sequence[Out_co]:
        """Stop, and be enabled no more."""
        ...


class Motor(Generic[Out]):
    """Sends nothing before a rate is asked for.

    A wheel never starts by itself: at first, after a fault, and when somebody else has let it go, a rate of
    zero must be asked for before it turns. Speeding up is limited; slowing down is left to the controller.
    """

    def __init__(self, throttle: Throttle | None, commands: Commands[Out]) -> None:
        """Without a throttle it never sends anything."""
        self._throttle = throttle
        self._commands = commands
        self._due_ns = 0
        self._enable_ns = 0
        self._rate = 0.0
        self._driven = False
        self._armed = False
        self._taken = False

    @property
    def deadline_ns(self) -> int:
        """When to step again."""
        return self._due_ns if self._throttle is not None else NEVER_NS

    @property
    def obeys(self) -> bool:
        """Whether it turns as it is asked to."""
        return self._driven and self._armed

    def asked(self, now_ns: int) -> bool:
        """Whether a rate is asked for, be it zero."""
        return self._throttle is not None and self._throttle.rate(now_ns) is not None

    def waits(self, now_ns: int) -> bool:
        """Whether it is asked to turn, and a rate of zero must be asked for first."""
        rate = self._throttle.rate(now_ns) if self._throttle else None
        return bool(rate) and not self._armed

    def step(self, now_ns: int, driven: bool, able: bool) -> Sequence[Out]:
        """What is to be sent now. `driven`: it says that it obeys; `able`: it is heard, and has no fault.

        One that is able no longer is let go, once, whether it hears that or not.
        """
        if self._throttle is None or now_ns < self._due_ns:
            return ()
        self._due_ns = now_ns + PERIOD_NS
        asked = self._throttle.rate(now_ns)
        if asked is None:
            return self.parting()
        if not able:
            return self.parting()
        self._armed = self._throttle.stands(now_ns) or (self._armed and driven)
        self._driven = driven
        self._throttle.obeyed = self.obeys
        if not (self._driven and self._armed):
            self._rate = 0.0
        if not self._armed:
            return ()
        self._taken = True
        return self._drive(asked, self._throttle.acceleration) if driven else self._enable(now_ns)

    def parting(self) -> Sequence[Out]:
        """What lets it go, if it was taken."""
        taken = self._taken
        self.lost()
        return self._commands.let_go() if taken else ()

    def lost(self) -> None:
        """Nobody knows any more what it does: the port was lost, or it is let go."""
        self._taken = self._armed = self._driven = False
        self._rate = 0.0
        if self._throttle is not None:
            self._throttle.obeyed = False

    def _drive(self, asked: float, acceleration: float) -> Sequence[Out]:
        self._rate = _towards(self._rate, asked, acceleration * PERIOD_S)
        return self._commands.drive(self._rate)

    def _enable(self, now_ns: int) -> Sequence[Out]:
        if now_ns < self._enable_ns:
            return ()
        self._enable_ns = now_ns + AGAIN_NS
        return self._commands.enable()


def _towards(rate: float, asked: float, most: float) -> float:
    """The next rate: slower at once, faster by at most so much, and through zero to the other direction."""
    start = abs(rate) if rate * asked > 0.0 else 0.0
    return copysign(min(abs(asked), start + most), asked)
