"""A voyage whose motors are well, and what else may go wrong."""

from types import SimpleNamespace
from typing import Any

from echogrid.drivers.readings import WheelReading
from echogrid.mapping.pose import Pose
from echogrid.mapping.twist import Twist
from echogrid.runtime.helm import HelmState
from echogrid.runtime.loop import SECOND_NS
from echogrid.runtime.modes.mode import End, Situation
from echogrid.runtime.voyage import Voyage


class WellHelm:
    state = HelmState.DRIVING
    stops = 0

    def steer(self, _now_ns: int, wanted: Twist, _reports: object) -> Twist:
        return wanted

    def release(self) -> None:
        self.state = HelmState.RELEASED


class Onward:
    name, patient = "onward", False
    end: End | None = None

    def wish(self, _: Situation) -> Twist:
        return Twist(0.3)

    def rest(self, _: int) -> None:
        pass


def voyage() -> Voyage:
    fusion: Any = SimpleNamespace(twist=Twist())
    helm: Any = WellHelm()
    return Voyage(fusion, helm, Onward(), ("left",))


def snapshot(second: float) -> Any:
    return SimpleNamespace(stamp_ns=round(second * SECOND_NS), pose=Pose(), pose_ns=None)


def test_without_a_pose_it_stands_and_a_mode_that_cannot_wait_ends_and_says_so() -> None:
    trip = voyage()
    for second in range(1, 40):
        trip.tick(snapshot(second), [], [])
        assert trip._fusion.twist == Twist()
    assert trip.over
    assert trip.end is not None
    assert (trip.end.reached, trip.end.told[:12]) == (False, "no pose for ")


def test_wheels_that_still_turn_when_they_are_let_go_are_told() -> None:
    trip = voyage()
    trip.tick(snapshot(1.0), [WheelReading(SECOND_NS, 0, "left", 0.0, 3.0)], [])
    trip.stop()
    for tenth in range(11, 40):
        trip.tick(snapshot(tenth / 10.0), [], [])
    assert trip.over
    assert trip.end is not None
    assert not trip.end.reached
    assert "still turned" in trip.end.told
