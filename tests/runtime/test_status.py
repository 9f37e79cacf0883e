from dataclasses import replace

import pytest

from echogrid.drivers.device import Health, State
from echogrid.mapping.virtual_sensor import StopReason
from echogrid.runtime.acquisition import DeviceReport
from echogrid.runtime.loop import FixedRateLoop
from echogrid.runtime.status import Meter

from .fakes import MS, SECOND, HandClock, echo
from .test_fusion import drive, fusion


def test_rates_are_those_since_the_last_look() -> None:
    state, loop = fusion(), FixedRateLoop(HandClock(), 50.0)
    meter = Meter(SECOND)
    for _ in range(25):
        meter.count(4)
    assert not meter.due(2 * SECOND - 1)
    assert meter.due(2 * SECOND)
    first = meter.look(state.tick(2 * SECOND, []), loop, [])
    assert (first.elapsed_s, first.tick_rate_hz, first.readings_per_s) == (1.0, 25.0, 100.0)
    second = meter.look(state.tick(4 * SECOND, []), loop, [])
    assert (second.elapsed_s, second.tick_rate_hz, second.readings_per_s) == (3.0, 0.0, 0.0)


def test_the_line_tells_the_nearest_obstacle_and_the_way_driven() -> None:
    state, loop = fusion(), FixedRateLoop(HandClock(), 50.0)
    pings = [echo(SECOND + k * 50 * MS, 0.8, "left") for k in range(20)]
    line = Meter(SECOND).look(state.tick(2 * SECOND, [*drive(1.0), *pings]), loop, []).line()
    assert "nearest 0.8" in line or "nearest 0.9" in line
    assert "at  +90 deg" in line
    assert "0.2 m driven" in line


def test_the_line_says_so_if_there_is_no_obstacle() -> None:
    line = Meter(SECOND).look(fusion().tick(SECOND, []), FixedRateLoop(HandClock(), 50.0), []).line()
    assert "STOP unknown  nearest none " in line


def test_eighty_columns_show_whether_to_stop_and_why_what_is_near_the_way_and_who_is_ill() -> None:
    state, loop = fusion(), FixedRateLoop(HandClock(), 50.0)
    devices = [DeviceReport(f"ring_{k}", "bus", Health(State.WELL, "", {})) for k in range(11)]
    ill = DeviceReport("b", "bus", Health(State.SILENT, "", {}))
    snapshot = state.tick(2 * SECOND, [*drive(1.0), echo(SECOND + 950 * MS, 0.3, "front")])
    shown = Meter(-3600 * SECOND).look(snapshot, loop, [*devices, ill]).line()[:79]
    assert "s  STOP near     nearest 0." in shown
    assert shown.endswith(" m driven  11/12 ok: b")


@pytest.mark.parametrize("reason", StopReason)
def test_the_line_tells_why_the_robot_stops(reason: StopReason) -> None:
    status = Meter(SECOND).look(fusion().tick(SECOND, []), FixedRateLoop(HandClock(), 50.0), [])
    view = replace(status.snapshot.view, reason=reason)
    line = replace(status, snapshot=replace(status.snapshot, view=view)).line()
    assert f"STOP {reason.value} " in line
