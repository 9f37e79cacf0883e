import struct
from itertools import pairwise
from math import inf

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pytest import approx

from echogrid.drivers.bus import CanFrame
from echogrid.drivers.device import Line
from echogrid.mapping.virtual_sensor import ObstacleView
from echogrid.runtime.outputs.beacon import Beacon
from echogrid.runtime.outputs.can_frames import frames
from echogrid.runtime.outputs.pace import Pace

from .views import CLEAR, STOPPED, at, views

MS = 1_000_000
REASONS = (None, "near", "silent", "unknown", "stale")


@given(views, st.integers(0, 2**33), st.integers(0, 0x1FFF_FFFE))
def test_an_independent_reader_finds_in_them_what_the_view_holds(
    view: ObstacleView, sequence: int, identifier: int
) -> None:
    way, around = frames(view, sequence, identifier)
    assert (way.identifier, around.identifier) == (identifier, identifier + 1)
    assert way.extended == around.extended == (identifier + 1 > 0x7FF)
    version, count, stop, reason, limit, free = struct.unpack("<BBBBHH", way.data)
    assert (version, count, stop) == (1, sequence % 256, view.stop)
    assert REASONS[reason] == (view.reason.value if view.reason else None)
    assert 0.0 <= view.speed_limit * 1e3 - limit < 1.0 or limit == 65534
    assert 0.0 <= view.path.distance * 1e3 - free < 1.0 or free == 65534
    version, count, bearing, nearest, age = struct.unpack("<BBhHH", around.data)
    assert (version, count) == (1, sequence % 256)
    assert bearing * 1e-4 == approx(view.nearest.bearing, abs=5.1e-5)
    assert (nearest == 65535) == (view.nearest.nearest == inf)
    assert (age == 65535) == (view.age_ns is None)


@pytest.mark.parametrize(
    ("view", "golden"),
    [(CLEAR, ("0107000077 01e2 04".replace(" ", ""), "01075c3dc8013400")), (STOPPED, None)],
)
def test_the_golden_frames(view: ObstacleView, golden: tuple[str, str] | None) -> None:
    expected = golden or ("0107010200000000", "01075c3dc801ffff")
    assert [frame.data.hex() for frame in frames(view, 7, 0x300)] == list(expected)


class Bench:
    """A beacon on a line that is stepped by hand."""

    def __init__(self, rate_hz: float = 20.0) -> None:
        self.beacon = Beacon("can:wheels:0x300", 0x300, Pace(rate_hz))
        self.line: Line[CanFrame, CanFrame] = Line("wheels", [self.beacon])

    def step(self, now_ns: int) -> tuple[CanFrame, ...]:
        return self.line.step(now_ns, ()).send


def test_each_view_goes_out_once_so_that_the_heartbeat_ends_with_the_loop() -> None:
    bench = Bench()
    assert bench.step(0) == ()
    bench.beacon.put(at(10 * MS))
    assert len(bench.step(20 * MS)) == 2
    assert [bench.step(now_ms * MS) for now_ms in range(40, 2000, 20)] == [()] * 98


def test_the_bus_looks_several_times_a_period() -> None:
    deadlines = [Bench().line.step(now, ()).deadline_ns - now for now in (0, 5 * MS)]
    assert all(wait_ns <= 50 * MS // 4 for wait_ns in deadlines)


@given(st.lists(st.sampled_from(["put", "step", "lost"]), max_size=40))
def test_every_view_is_sent_or_dropped(story: list[str]) -> None:
    bench, now_ns, put = Bench(), 0, 0
    sequences = []
    for what in story:
        now_ns += 60 * MS
        if what == "put":
            bench.beacon.put(at(now_ns))
            put += 1
        elif what == "lost":
            bench.line.lost(now_ns)
        else:
            sequences += [frame.data[1] for frame in bench.step(now_ns)[:1]]
    sequences += [frame.data[1] for frame in bench.step(now_ns + 60 * MS)[:1]]
    assert put == bench.beacon.sent + bench.beacon.dropped.total()
    assert len(sequences) == bench.beacon.sent
    assert all(after > before for before, after in pairwise(sequences))


def test_what_waited_for_a_lost_bus_is_not_sent_when_it_comes_back() -> None:
    bench = Bench()
    bench.beacon.put(at(10 * MS))
    bench.line.lost(20 * MS)
    assert bench.step(30 * MS) == ()
    assert bench.beacon.dropped == {"bus lost": 1}
