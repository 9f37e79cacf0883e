"""A robot that goes where its two motors turn its wheels, until it meets something: then they stall."""

from collections.abc import Callable
from math import inf

from echogrid.emulation.body import Body
from echogrid.emulation.devices.shaft import MotorShaft, Shaft
from echogrid.emulation.plant import STEP_NS, Drive, Encoders, Plant
from echogrid.emulation.reflectors import Pose
from echogrid.emulation.vista import Post
from echogrid.emulation.world import World

_SIDES = ("left", "right")


class StallingBase:
    """The plant, led by the shafts of two motors, each as the encoder on it sees it."""

    def __init__(
        self,
        world: World,
        body: Body,
        start: Pose,
        people_at: Callable[[int], tuple[Post, ...]],
        encoders: Encoders,
        track: float,
    ) -> None:
        """`track` is what lies between the wheels, m; their radius is the encoders'."""
        at_once = Drive(inf, inf, inf, inf, 0, track, encoders.wheel_radius)
        self.plant = Plant(world, body, at_once, start, people_at)
        """It stands at the start until a motor turns."""
        self._motors = MotorShaft(), MotorShaft()
        self._encoders = encoders
        self._turned = (0.0, 0.0)
        """rad, by the motors, up to the plant's time."""
        self._measured = encoders.read((0.0, 0.0))
        self._stalled = False

    def shaft(self, side: str) -> Shaft:
        """Of the "left" or the "right" wheel."""
        number = _SIDES.index(side)
        return _Measured(self._motors[number], lambda now_ns: self._angle(number, now_ns))

    def pose(self, now_ns: int) -> Pose:
        """Where it is, or was; of what is to come, where it was last."""
        self._advance(now_ns)
        return self.plant.pose_at(now_ns)

    def _angle(self, number: int, now_ns: int) -> float:
        """rad, as measured at the last step, and as the motor turned since."""
        self._advance(now_ns)
        since = self._motors[number](now_ns) - self._turned[number]
        return self._measured[number] + (0.0 if self._stalled else since)

    def _advance(self, now_ns: int) -> None:
        while self.plant.now_ns + STEP_NS <= now_ns:
            self._step()

    def _step(self) -> None:
        plant, limits = self.plant, self.plant.drive
        turned = tuple(motor(plant.now_ns + STEP_NS) for motor in self._motors)
        left, right = (
            limits.wheel_radius * (after - before) * 1e9 / STEP_NS
            for before, after in zip(self._turned, turned, strict=True)
        )
        self._turned = turned[0], turned[1]
        speed, turn_rate = (left + right) / 2.0, (right - left) / limits.track
        plant.ask(speed, turn_rate)
        plant.step()
        self._stalled = (plant.speed, plant.turn_rate) != (speed, turn_rate)
        self._measured = self._encoders.read(plant.wheels)


class _Measured(Shaft):
    """A motor's shaft, seen by an encoder."""

    def __init__(self, motor: Shaft, angle: Callable[[int], float]) -> None:
        super().__init__(angle)
        self._motor = motor

    def drive(self, rate: float, now_ns: int) -> None:
        """The motor holds it at that rate (rad/s of the wheel) from now on."""
        self._motor.drive(rate, now_ns)

    def release(self, now_ns: int) -> None:
        """The motor lets it roll."""
        self._motor.release(now_ns)
