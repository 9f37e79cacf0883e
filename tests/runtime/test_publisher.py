import json

import pytest

from echogrid.mapping.virtual_sensor import ObstacleView
from echogrid.runtime.loop import FixedRateLoop
from echogrid.runtime.outputs.publisher import Mailbox, Publisher
from echogrid.runtime.service import Run

from .fakes import SECOND, HandClock
from .test_fusion import drive, fusion
from .test_service import Supply, ignore
from .views import CLEAR, STOPPED


class Grudge:
    """A subscriber that has had enough after one view."""

    def __init__(self) -> None:
        self.seen: list[ObstacleView] = []

    def __call__(self, view: ObstacleView) -> None:
        self.seen.append(view)
        if len(self.seen) == 2:
            raise LookupError("enough")


def test_every_subscriber_gets_the_very_same_view() -> None:
    publisher, seen, mailbox = Publisher(), list[ObstacleView](), Mailbox()
    publisher.subscribe(seen.append)
    publisher.subscribe(mailbox)
    assert mailbox.newest is None
    for view in (CLEAR, STOPPED):
        publisher.put(view)
        assert mailbox.newest is view
    assert [id(view) for view in seen] == [id(CLEAR), id(STOPPED)]


def test_a_subscriber_that_raises_is_told_no_more_and_the_others_are() -> None:
    publisher, grudge, seen = Publisher(), Grudge(), list[ObstacleView]()
    publisher.subscribe(grudge)
    publisher.subscribe(seen.append)
    for _ in range(4):
        publisher.put(CLEAR)
    assert (len(grudge.seen), len(seen)) == (2, 4)
    assert publisher.report() == {"subscribers": {"failed": ["LookupError('enough')"]}}


@pytest.mark.parametrize("ticks", [1, 50])
def test_a_run_publishes_the_view_of_every_tick_and_of_the_last_readings(ticks: int) -> None:
    clock, seen = HandClock(SECOND), list[ObstacleView]()
    publisher = Publisher()
    publisher.subscribe(seen.append)
    supply = Supply(clock, drive())
    run = Run(fusion(), FixedRateLoop(clock, 50.0), supply, clock, publisher=publisher)
    run.go((ticks + 0.5) / 50.0, ignore)
    assert len(seen) == ticks + 1
    assert json.loads(json.dumps(run.report([])))["outputs"] == {}
