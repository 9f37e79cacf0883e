"""Who is told of each tick's obstacle view."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol

from echogrid.mapping.virtual_sensor import ObstacleView

Subscriber = Callable[[ObstacleView], None]


class Output(Protocol):
    """A way out. Nothing that it does may wait, or raise."""

    name: str
    sent: int
    dropped: Counter[str]

    def put(self, view: ObstacleView) -> None:
        """Take the view of a tick."""
        ...

    def close(self) -> None:
        """Let go what it holds. May be called twice."""
        ...


class Mailbox:
    """The newest view, for another thread of this process to look at whenever it likes."""

    def __init__(self) -> None:
        self.newest: ObstacleView | None = None
        """None before the first tick. To be believed for as long as its stamp is fresh."""

    def __call__(self, view: ObstacleView) -> None:
        """Take the view of a tick."""
        self.newest = view


class Publisher:
    """Hands every view to the outputs, and to subscribers in this process, who see it as it is.

    A subscriber is called by the loop, and must not wait. One that raises is counted and told no more.
    """

    def __init__(self, outputs: Sequence[Output] = ()) -> None:
        self.outputs = tuple(outputs)
        self.failed: list[str] = []
        """What subscribers raised."""
        self._subscribers: tuple[Subscriber, ...] = ()

    def subscribe(self, subscriber: Subscriber) -> None:
        """Call it with every view from now on."""
        self._subscribers = (*self._subscribers, subscriber)

    def put(self, view: ObstacleView) -> None:
        """Publish the view of a tick."""
        for output in self.outputs:
            output.put(view)
        for subscriber in self._subscribers:
            try:
                subscriber(view)
            except Exception as error:  # noqa: BLE001 - the loop must outlive any fault of a subscriber
                self.failed.append(repr(error))
                self._subscribers = tuple(each for each in self._subscribers if each is not subscriber)

    def close(self) -> None:
        """Let all outputs go. May be called twice."""
        for output in self.outputs:
            output.close()

    def report(self) -> Mapping[str, Any]:
        """What report.json holds of them."""
        told = {
            output.name: {"sent": output.sent, "dropped": dict(sorted(output.dropped.items()))}
            for output in self.outputs
        }
        return told | ({"subscribers": {"failed": self.failed}} if self.failed else {})
