"""What is around the robot now: the local grid, what is read from it, and the stop layer beneath."""

from collections.abc import Iterable
from dataclasses import replace

from echogrid.drivers.readings import Outcome, RangeReading
from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.placed_ping import PlacedPing
from echogrid.mapping.pose import Pose
from echogrid.mapping.stop_layer import StopLayer
from echogrid.mapping.verification import Believer, Verifier, heard_at
from echogrid.mapping.virtual_sensor import ObstacleView, StopReason, VirtualSensor


class Lookout:
    """The stop layer hears every reading; the local grid sees those which are verified."""

    def __init__(
        self, local: LocalGrid, sensor: VirtualSensor, stop: StopLayer, verifier: Verifier | Believer
    ) -> None:
        self._local = local
        self._sensor = sensor
        self._stop = stop
        self._verifier = verifier

    def hear(self, readings: Iterable[RangeReading]) -> None:
        """Raw readings, as they came in."""
        for reading in readings:
            self._stop.take(reading)

    def see(self, placed: Iterable[PlacedPing], robot: Pose, now_ns: int) -> None:
        """Fuse newly placed pings into the grid around the robot (its pose in the odom frame)."""
        self._local.centre(robot)
        self._local.fade(now_ns)
        for ping in placed:
            for verified in self._verifier.take(ping).verified:
                self._fuse(verified)

    def view(self, robot: Pose, now_ns: int) -> ObstacleView:
        """The obstacles around the robot."""
        view = self._sensor.view(self._local, robot, now_ns)
        return replace(view, reason=StopReason.NEAR) if self._stop.must_stop(now_ns) else view

    def _fuse(self, ping: PlacedPing) -> None:
        """For avoidance, what is too close is an obstacle at the blanking distance."""
        if ping.reading.outcome is not Outcome.INVALID:
            self._local.fuse(ping.transducer, ping.ranger, heard_at(ping), ping.reading.stamp_ns)
