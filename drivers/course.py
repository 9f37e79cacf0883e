"""What a device does step by step, written as a generator that neither waits nor does input or output."""

from collections.abc import Generator, Sequence
from errno import ETIMEDOUT
from typing import Generic, TypeVar

from echogrid.drivers.bus import Result, Transfer

T = TypeVar("T")
Course = Generator[Transfer | int, Result[Transfer], T]
"""A transfer that it yields is sent, and its result comes back from the yield; an int is a time (ns) to wait
for, and what comes back then is the last result once more."""

ANSWER_WITHIN_NS = 5_000_000_000
"""A transfer whose result stays away for so long has failed: its bus is held up. On a line that several
devices share it may have to wait for a few of the slowest, which take 0.7 s each."""


class Pilot(Generic[Transfer]):
    """Takes a course that never ends through time: one transfer or one wait at a time."""

    def __init__(self, idle: Transfer) -> None:
        """`idle` stands for the transfer before the first."""
        self.now_ns = 0
        self.deadline_ns = 0
        """When to step again, if nothing comes in before."""
        self.unanswered = 0
        """How many transfers got no result in time."""
        self._result: Result[Transfer] = Result(idle, 0, 0)
        self._wish: Transfer | int = 0
        self._send: list[Transfer] = []

    def start(self, course: Course[Transfer, None], now_ns: int) -> None:
        """Leave the course that was, and begin this one with the next step."""
        self._course = course
        self._send.clear()
        self.now_ns = self.deadline_ns = self._wish = now_ns
        self._fresh = True

    def step(self, now_ns: int, received: Sequence[Result[Transfer]]) -> tuple[Transfer, ...]:
        """Go as far as the time and the results allow; what is to be sent."""
        self.now_ns = now_ns
        for result in received:
            if result.transfer is self._wish:
                self._go_on(result)
        if now_ns >= self.deadline_ns:
            self._overdue()
        send, self._send = tuple(self._send), []
        return send

    def wake(self) -> None:
        """End the wait, if it is one that lasts."""
        if isinstance(self._wish, int) and not self._fresh:
            self._go_on(self._result)

    def _overdue(self) -> None:
        """The time waited for has come; if it was for a result, that stayed away."""
        if isinstance(self._wish, int):
            self._go_on(self._result)
        else:
            self.unanswered += 1
            self._go_on(Result(self._wish, self.now_ns, self.now_ns, errno=ETIMEDOUT))

    def _go_on(self, result: Result[Transfer]) -> None:
        self._result = result
        self._wish = self._next()
        while isinstance(self._wish, int) and self._wish <= self.now_ns:
            self._wish = self._next()
        if isinstance(self._wish, int):
            self.deadline_ns = self._wish
        else:
            self._send.append(self._wish)
            self.deadline_ns = self.now_ns + ANSWER_WITHIN_NS

    def _next(self) -> Transfer | int:
        if self._fresh:
            self._fresh = False
            return next(self._course)
        return self._course.send(self._result)
