import json
from math import isinf

from hypothesis import given
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.virtual_sensor import ObstacleView
from echogrid.runtime.outputs.json_line import line

from .views import CLEAR, STOPPED, views


@given(views, st.integers(0, 2**40))
def test_it_is_one_line_of_strict_json_that_holds_the_view(view: ObstacleView, sequence: int) -> None:
    data = line(view, sequence)
    assert data.count(b"\n") == 1
    assert data.endswith(b"\n")
    told = json.loads(data, parse_constant=lambda word: pytest_fail(word))
    assert (told["echogrid"], told["sequence"], told["stamp_ns"]) == (1, sequence, view.stamp_ns)
    assert (told["stop"], told["unknown"]) == (view.stop, view.unknown.value)
    assert told["reason"] == (view.reason.value if view.reason else None)
    assert told["silent"] == list(view.silent)
    assert told["speed_limit_mps"] == approx(view.speed_limit, abs=1e-4)
    assert told["allowed"] == approx([view.allowed.speed, view.allowed.turn_rate], abs=1e-4)
    assert (told["path"]["collision_s"] is None) == isinf(view.path.seconds)
    assert told["path"]["free_m"] == approx(view.path.distance, abs=1e-4)
    for one, other in zip(told["sectors"], view.sectors, strict=True):
        assert one["state"] == other.state.value
        assert one["bearing"] == approx(other.bearing, abs=1e-4)
        assert (
            one["nearest_m"] is None
            if isinf(other.nearest)
            else one["nearest_m"] == approx(other.nearest, abs=1e-4)
        )
        assert (
            one["age_s"] is None
            if other.age_ns is None
            else one["age_s"] == approx(other.age_ns * 1e-9, abs=1e-6)
        )


def pytest_fail(word: str) -> None:
    raise AssertionError(f"{word} is no JSON")


def test_a_stop_tells_why_and_who_is_silent() -> None:
    told = json.loads(line(STOPPED, 5))
    assert (told["stop"], told["reason"], told["silent"], told["age_s"]) == (True, "silent", ["front"], None)
    assert (told["speed_limit_mps"], told["allowed"]) == (0.0, [0.0, 0.0])


def test_the_golden_line() -> None:
    assert line(CLEAR, 7).decode().split('"sectors"')[0] == (
        '{"echogrid":1,"sequence":7,"stamp_ns":1234567890123,"age_s":0.052,"stop":false,"reason":null,'
        '"unknown":"slow","silent":[],"latency_s":0.25,"speed_limit_mps":0.375,"allowed":[0.375,-0.1875],'
        '"path":{"twist":[0.5,-0.25],"free_m":1.25,"collision_s":2.5,"end":"obstacle","limit_mps":0.375},'
    )
