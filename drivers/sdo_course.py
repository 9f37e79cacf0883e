"""What is done with a CANopen node's objects step by step: a generator asks, and gets the answers back."""

from collections.abc import Generator, Iterable
from typing import Generic, TypeVar

from echogrid.drivers.bus import CanFrame
from echogrid.drivers.sdo import SdoAnswer, SdoClient, SdoRequest

T = TypeVar("T")
SdoCourse = Generator[SdoRequest, SdoAnswer, T]
"""A request that it yields is sent, and its answer comes back from the yield."""


def do_all(requests: Iterable[SdoRequest]) -> SdoCourse[str]:
    """Do one after the other, up to the first that fails; why that did, empty if none did."""
    for request in requests:
        answer = yield request
        if answer.trouble:
            return answer.trouble
    return ""


class SdoPilot(Generic[T]):
    """Takes one course at a time to its end."""

    def __init__(self, node: int) -> None:
        self.outcome: T | None = None
        """What the course returned; None before its end."""
        self._client = SdoClient(node)
        self._course: SdoCourse[T] | None = None

    @property
    def deadline_ns(self) -> int:
        """When to step again."""
        return self._client.deadline_ns

    @property
    def busy(self) -> bool:
        """Whether a course is under way."""
        return self._course is not None

    def start(self, course: SdoCourse[T]) -> None:
        """Leave the course that was, and begin this one with the next step."""
        self.stop()
        self._course = course
        self._go_on(None)

    def stop(self) -> None:
        """Leave the course that was."""
        self._client.forget()
        self._course = self.outcome = None

    def take(self, data: bytes) -> bool:
        """Take the 8 bytes of a reply; whether it was waited for."""
        answer = self._client.take(data)
        if answer is not None:
            self._go_on(answer)
        return answer is not None

    def step(self, now_ns: int) -> tuple[CanFrame, ...]:
        """What is to be sent now."""
        failed, send = self._client.step(now_ns)
        if failed is not None:
            self._go_on(failed)
            send = self._client.step(now_ns)[1]
        return send

    def _go_on(self, answer: SdoAnswer | None) -> None:
        if self._course is None:
            return
        try:
            request = next(self._course) if answer is None else self._course.send(answer)
        except StopIteration as end:
            self._course, self.outcome = None, end.value
        else:
            self._client.ask(request)
