from dataclasses import replace
from math import inf

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.virtual_sensor import ObstacleView
from echogrid.runtime.outputs.binary import datagram

from .told_view import RefusedError, told
from .views import CLEAR, STOPPED, views

GOLDEN_CLEAR = (
    "45474f56 01 00 00 01 07000000 6400 0400 cb04fb711f010000 20cb0000 90d00300"
    "0000c03e 0000a03f 00002040 0000003f 000080be 0000c03e 000040be 00 000000"
    "0000 ffff 2800 bf 00  5c3d c801 3e00 e0 01  4885 ffff ffff 00 02  a4c2 e204 feff b2 03"
    "6a791607"
)
GOLDEN_STOPPED = (
    "45474f56 01 03 02 01 07000000 6400 0400 cb312c731f010000 ffffffff 90d00300"
    "00000000 00000000 0000807f 00000000 00000000 00000000 00000000 01 000000"
    "0000 ffff 2800 bf 00  5c3d c801 3e00 e0 01  4885 ffff ffff 00 02  a4c2 e204 feff b2 03"
    "7fe398bd"
)
"""Header by header and sector by sector as in the tables of docs/obstacle-sensor.md."""


def seconds(age_ns: int | None) -> float:
    return inf if age_ns is None else age_ns * 1e-9


@given(views, st.integers(0, 2**33))
def test_an_independent_reader_finds_in_it_what_the_view_holds(view: ObstacleView, sequence: int) -> None:
    data = datagram(view, sequence)
    found = told(data)
    assert found.sequence == sequence % 2**32
    assert (found.stop, found.stamp_ns, found.unknown) == (view.stop, view.stamp_ns, view.unknown.value)
    assert found.reason == (view.reason.value if view.reason else None)
    assert found.silent == bool(view.silent)
    assert found.speed_limit == approx(view.speed_limit, rel=1e-6)
    assert (found.free, found.collision_s) == approx((view.path.distance, view.path.seconds), rel=1e-6)
    assert found.twist == approx((view.path.twist.speed, view.path.twist.turn_rate), rel=1e-6)
    assert found.allowed == approx((view.allowed.speed, view.allowed.turn_rate), rel=1e-5, abs=1e-30)
    assert found.end == view.path.end.value
    assert found.age_s == approx(
        min(seconds(view.age_ns), 4294.967294) if view.age_ns is not None else inf, abs=2e-6
    )
    assert len(found.sectors) == len(view.sectors)
    for one, other in zip(found.sectors, view.sectors, strict=True):
        assert one.bearing == approx(other.bearing, abs=5.1e-5)
        assert one.state == other.state.value
        assert one.confidence == approx(other.confidence, abs=0.002)
        assert one.nearest <= other.nearest + 1e-9
        assert (
            one.nearest == approx(min(other.nearest, 65.534), abs=0.00101)
            or one.nearest == other.nearest == inf
        )
        assert one.age_s >= min(seconds(other.age_ns), 65.534) - 1e-9
        assert one.age_s == approx(min(seconds(other.age_ns), 65.534), abs=0.00101) or one.age_s == inf


@given(views, st.data())
def test_a_datagram_that_was_changed_is_refused(view: ObstacleView, data: st.DataObject) -> None:
    whole = datagram(view, 7)
    bent = bytearray(whole)
    for _ in range(data.draw(st.integers(1, 4))):
        bent[data.draw(st.integers(0, len(whole) - 1))] = data.draw(st.integers(0, 255))
    if bytes(bent) == whole:
        assert told(bytes(bent)) == told(whole)
    else:
        with pytest.raises(RefusedError):
            told(bytes(bent))


@given(views, st.data())
def test_one_that_was_cut_or_lengthened_is_refused(view: ObstacleView, data: st.DataObject) -> None:
    whole = datagram(view, 7)
    for other in (
        whole[: data.draw(st.integers(0, len(whole) - 1))],
        whole + data.draw(st.binary(min_size=1)),
    ):
        with pytest.raises(RefusedError):
            told(other)


@given(st.binary(max_size=300))
def test_noise_is_refused(noise: bytes) -> None:
    with pytest.raises(RefusedError):
        told(noise)


@given(views, st.integers(0, 255).filter(lambda version: version != 1))
def test_another_version_is_refused(view: ObstacleView, version: int) -> None:
    data = bytearray(datagram(view, 0))
    data[4] = version
    with pytest.raises(RefusedError, match=f"version {version}"):
        told(bytes(data))


@pytest.mark.parametrize("view", [CLEAR, STOPPED])
def test_equal_views_of_equal_number_are_equal_bytes(view: ObstacleView) -> None:
    assert datagram(view, 3) == datagram(replace(view), 3)


@pytest.mark.parametrize(("view", "golden"), [(CLEAR, GOLDEN_CLEAR), (STOPPED, GOLDEN_STOPPED)])
def test_the_golden_bytes(view: ObstacleView, golden: str) -> None:
    assert datagram(view, 7).hex() == bytes.fromhex(golden).hex()
