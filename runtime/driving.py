"""From a twist to what the wheels' motors are asked for, within the robot's limits."""

from math import radians

from echogrid.drivers.throttle import Throttle
from echogrid.mapping.kinematics import Differential
from echogrid.runtime.config import Config


class Driving:
    """The throttles of both wheels. Each twist is to be asked for anew while it shall last."""

    def __init__(self, config: Config, kinematics: Differential) -> None:
        limits = config.drive
        self._kinematics = kinematics
        self._most = limits.max_speed_mps, radians(limits.max_turn_dps)
        radii = {"left": kinematics.left_radius, "right": kinematics.right_radius}
        self.throttles: dict[str, Throttle] = {
            wheel.name: Throttle(wheel.fastest_rad_s, limits.acceleration_mps2 / radii[wheel.name])
            for wheel in config.wheel
        }
        self._fastest = {wheel.name: wheel.fastest_rad_s for wheel in config.wheel}

    @property
    def obeyed(self) -> bool:
        """Whether both motors are enabled, and turn as they are asked to."""
        return all(throttle.obeyed for throttle in self.throttles.values())

    def ask(self, now_ns: int, speed: float, turn_rate: float) -> tuple[float, float]:
        """Ask for a twist (m/s, rad/s); what of it is within the limits, on the same curve."""
        left, right = self._kinematics.rates(speed, turn_rate)
        excess = max(
            1.0,
            abs(speed) / self._most[0],
            abs(turn_rate) / self._most[1],
            abs(left) / self._fastest["left"],
            abs(right) / self._fastest["right"],
        )
        self.throttles["left"].ask(now_ns, left / excess)
        self.throttles["right"].ask(now_ns, right / excess)
        return speed / excess, turn_rate / excess

    def release(self) -> None:
        """Let the motors go."""
        for throttle in self.throttles.values():
            throttle.release()
