"""A wheel's controller that restarts must not turn the robot."""

from math import degrees

import pytest

from echogrid.mapping.pose import wrap_angle
from echogrid.runtime import robot_file
from echogrid.runtime.emulated import DEFAULT_ROBOT
from echogrid.runtime.loop import SECOND_NS
from echogrid.runtime.simulated_run import simulated_run
from echogrid.runtime.status import Status


@pytest.mark.parametrize("verb", ["off", "unplug"])
@pytest.mark.parametrize("wheel", ["left", "right"])
def test_a_restart_on_a_straight_line_loses_way_but_not_heading(wheel: str, verb: str) -> None:
    """From 9.5 s on the tour goes straight for some seconds."""
    run, robot = simulated_run(robot_file.load(DEFAULT_ROBOT), 1)
    headings: list[float] = []
    doubts: list[float] = []

    def show(status: Status) -> None:
        headings.append(status.snapshot.pose.yaw)
        doubts.append(status.snapshot.covariance[:2, :2].trace() ** 0.5)
        if len(headings) == 9:
            robot.fault(wheel, verb, run.clock.now_ns(), 4 * SECOND_NS // 5)

    run.go(13.5, show)
    assert degrees(abs(wrap_angle(headings[-1] - headings[8]))) < 1.0
    report = run.report(run.acquisition.report(run.clock.now_ns()))
    assert report["wheel_restarts"] == 1
    assert doubts[8] < 0.1
    assert report["pose_error"]["y_m"] > 0.2
