"""Obstacle views to publish."""

from dataclasses import replace
from math import inf, pi

from hypothesis import strategies as st

from echogrid.mapping.free_path import FreePath, PathEnd
from echogrid.mapping.twist import Twist
from echogrid.mapping.unknown import Unknown
from echogrid.mapping.virtual_sensor import ObstacleView, Sector, SectorState, StopReason

CLEAR = ObstacleView(
    1_234_567_890_123,
    (
        Sector(0.0, SectorState.CLEAR, inf, 0.75, 40_000_000, 0.8),
        Sector(pi / 2.0, SectorState.BLOCKED, 0.4567, 0.88, 61_000_001, 0.6),
        Sector(-pi, SectorState.UNKNOWN, inf, 0.0, None, 0.0),
        Sector(-pi / 2.0, SectorState.STALE, 1.25, 0.7, 70_000_000_000, 0.1),
    ),
    None,
    Unknown.SLOW,
    FreePath(Twist(0.5, -0.25), 1.25, 2.5, PathEnd.OBSTACLE, 0.375, 0.5),
    (),
    52_000_000,
    250_000_000,
)
STOPPED = replace(
    CLEAR,
    stamp_ns=CLEAR.stamp_ns + 20_000_000,
    reason=StopReason.SILENT,
    silent=("front",),
    path=FreePath(Twist(), 0.0, inf, PathEnd.UNKNOWN, 0.0, 0.0),
    age_ns=None,
)

numbers = st.floats(0.0, 50.0, width=32)
ages = st.none() | st.integers(0, 10**13)
sectors = st.builds(
    Sector,
    st.floats(-pi, pi),
    st.sampled_from(SectorState),
    st.floats(0.0, 80.0) | st.just(inf),
    st.floats(0.0, 1.0),
    ages,
    st.floats(0.0, 1.0),
)
twists = st.builds(Twist, st.floats(-2.0, 2.0, width=32), st.floats(-5.0, 5.0, width=32))
views = st.builds(
    ObstacleView,
    st.integers(0, 2**62),
    st.lists(sectors, min_size=4, max_size=8).map(tuple),
    st.none() | st.sampled_from(StopReason),
    st.sampled_from(Unknown),
    st.builds(FreePath, twists, numbers, numbers | st.just(inf), st.sampled_from(PathEnd), numbers, numbers),
    st.lists(st.sampled_from(["front", "left"]), max_size=2).map(tuple),
    ages,
    st.integers(0, 10**10),
)


def at(stamp_ns: int, stop: bool = False) -> ObstacleView:
    """The same view at another time."""
    return replace(STOPPED if stop else CLEAR, stamp_ns=stamp_ns)
