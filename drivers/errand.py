"""Something that is done once on a bus, such as looking who is there: a device which runs one course."""

from collections.abc import Callable, Mapping, Sequence
from typing import Generic, TypeVar

from echogrid.drivers.bus import NEVER_NS, Result, Transfer
from echogrid.drivers.course import Course, Pilot
from echogrid.drivers.device import Health, State, Step

T = TypeVar("T")


class Errand(Generic[Transfer, T]):
    """Runs a course to its end, from the start if the port is lost meanwhile."""

    def __init__(
        self,
        make_course: Callable[["Errand[Transfer, T]"], Course[Transfer, T]],
        idle: Transfer,
        port_options: Mapping[str, object],
    ) -> None:
        """`make_course` is given the errand, for its time; `idle` is any transfer."""
        self.name = "errand"
        self.port_options = port_options
        self.outcome: T | None = None
        self.done = False
        self._make_course = make_course
        self._pilot = Pilot(idle)
        self._pilot.start(self._run(), 0)

    @property
    def now_ns(self) -> int:
        """The time of the step under way."""
        return self._pilot.now_ns

    def step(self, now_ns: int, received: Sequence[Result[Transfer]]) -> Step[Transfer]:
        """Go as far as the time and the results allow."""
        send = self._pilot.step(now_ns, received)
        return Step(send=send, deadline_ns=self._pilot.deadline_ns)

    def lost(self, now_ns: int) -> None:
        """The port was lost: begin anew."""
        self._pilot.start(self._run(), now_ns)

    def health(self, now_ns: int) -> Health:
        """Whether it has done."""
        del now_ns
        return Health(State.WELL if self.done else State.SETTING_UP, "done" if self.done else "under way", {})

    def _run(self) -> Course[Transfer, None]:
        self.outcome = yield from self._make_course(self)
        self.done = True
        while True:
            yield NEVER_NS
