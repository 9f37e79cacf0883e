import pytest

from echogrid.drivers.device import State
from echogrid.runtime import robot_file
from echogrid.runtime.emulated import DEFAULT_ROBOT
from echogrid.runtime.simulated_run import simulated_run
from echogrid.runtime.status import Status


@pytest.mark.parametrize("ranger", ["ring_270", "front_right"])
def test_a_ranger_that_is_stuck_is_told_as_soon_as_the_robot_moved_and_only_that(ranger: str) -> None:
    config = robot_file.load(DEFAULT_ROBOT)
    run, robot = simulated_run(config, 1)
    seen: list[set[str]] = []

    def look(status: Status) -> None:
        if len(seen) == 5:
            robot.fault(ranger, "stuck", run.clock.now_ns())
        seen.append({each.device for each in status.devices if each.health.state is State.STUCK})

    run.go(30.0, look)
    assert set().union(*seen[:6]) == set()
    assert seen[-1] == {ranger}
