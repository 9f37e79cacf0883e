"""What a robot is built of, in robot.toml: its body, its buses, and the devices on them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import radians
from typing import Any, Literal

from echogrid.mapping.footprint import Footprint
from echogrid.mapping.kinematics import Differential, Tricycle, Wheels
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.sonar_model import NoEcho
from echogrid.runtime.requirement import require


def _require_outline(corners: Sequence[Sequence[float]]) -> None:
    if not corners:
        return
    alike = all(len(corner) == 2 and max(map(abs, corner)) <= 100 for corner in corners)
    require(alike, "`footprint` must be a list of [x_m, y_m] in -100...100")
    try:
        Footprint([(x, y) for x, y in corners])
    except ValueError as error:
        raise ValueError(f"`footprint`: {error}") from error


@dataclass(frozen=True, slots=True)
class RobotConfig:
    """[robot]"""

    name: str = "robot"
    wheel_radius_m: float | None = None
    """The mean of both; of a steered drive the driven wheel's."""
    track_m: float | None = None
    wheel_ratio: float = 1.0
    """The right wheel's radius over the left one's."""
    slip_factor: float = 1.0
    """Skid-steer: the effective track over the measured one."""
    wheel_error_mm: float = 5.0
    """The standard deviation of a wheel's way after 1 m; it grows with the root of the way."""
    drive: Literal["differential", "tricycle", "ackermann"] = "differential"
    wheelbase_m: float | None = None
    """Steered drives: from the axle that is not steered to the steered wheel."""
    steering_error_deg: float = 1.0
    """Steered drives: the standard deviation of the mean steering angle over a way of 1 m."""
    air_temperature_c: float = 20.0
    footprint: tuple[tuple[float, ...], ...] = ()
    """Corners (x_m, y_m) of its outline, in order; by default a box around wheels and rangers."""

    def __post_init__(self) -> None:
        _require_outline(self.footprint)
        for name in ("wheel_radius_m", "track_m", "wheelbase_m"):
            value = getattr(self, name)
            require(value is None or 0.001 <= value <= 100, f"`{name}` must lie in 0.001...100")
        require(0.5 <= self.wheel_ratio <= 2, "`wheel_ratio` must lie in 0.5...2")
        require(0.5 <= self.slip_factor <= 10, "`slip_factor` must lie in 0.5...10")
        require(0 < self.wheel_error_mm <= 1000, "`wheel_error_mm` must lie in 0...1000")
        require(0 < self.steering_error_deg <= 90, "`steering_error_deg` must lie in 0...90")
        require(-40 <= self.air_temperature_c <= 85, "`air_temperature_c` must lie in -40...85")

    @property
    def wheels(self) -> Wheels:
        """What its two [[wheel]]s are called."""
        return Differential.wheels if self.drive == "differential" else Tricycle.wheels


@dataclass(frozen=True, slots=True)
class BusConfig:
    """[[bus]]: a port, and what speaks on it."""

    name: str
    kind: Literal["serial", "i2c", "can", "iio"]
    port: str
    """A path, or unix:PATH for I2C or IIO over a socket; relative to the folder of robot.toml."""
    interface: str = "socketcan"
    """CAN: the python-can interface."""
    bit_rate: int | None = None
    """Serial: baud (by default the devices' own). CAN: bit/s (by default as the interface is set up)."""
    listen_only: bool = False
    """CAN: nothing at all is sent."""

    def __post_init__(self) -> None:
        require(not self.listen_only or self.kind == "can", "`listen_only` is for CAN buses")


@dataclass(frozen=True, slots=True)
class SensorConfig:
    """[[sensor]]: a ranger's place on the robot, and its driver with that driver's own settings."""

    name: str
    x_m: float
    y_m: float
    yaw_deg: float
    half_angle_deg: float
    min_m: float
    max_m: float
    driver: str | None = None
    bus: str | None = None
    settings: Mapping[str, Any] = field(default_factory=dict)
    tolerance_m: float | None = None
    """Its own, where it is not that of [map]; so are the following two."""
    silence: NoEcho | None = None
    """What [map] calls `no_echo`, a word that is a driver's own."""
    detection: float | None = None
    """How often an obstacle on the axis and near answers."""

    def __post_init__(self) -> None:
        plain = self.name.isprintable() and self.name == self.name.strip()
        require(plain, "`name` must be printable, without blanks around it")
        require(abs(self.x_m) <= 100 and abs(self.y_m) <= 100, "`x_m` and `y_m` must lie in -100...100")
        require(abs(self.yaw_deg) <= 36_000, "`yaw_deg` must lie in -36000...36000")
        require(0 < self.half_angle_deg < 90, "`half_angle_deg` must lie between 0 and 90")
        require(0 <= self.min_m < self.max_m, "`min_m` must be at least 0 and below `max_m`")
        require(self.max_m <= 100, "`max_m` must be at most 100")
        tolerable = self.tolerance_m is None or 0 < self.tolerance_m <= 10
        require(tolerable, "`tolerance_m` must be above 0 and at most 10")
        likely = self.detection is None or 0 <= self.detection <= 0.99
        require(likely, "`detection` must lie in 0...0.99")

    def ranger(self) -> Ranger:
        """As the map sees it."""
        mount = Pose(self.x_m, self.y_m, radians(self.yaw_deg))
        return Ranger(
            self.name,
            mount,
            radians(self.half_angle_deg),
            self.min_m,
            self.max_m,
            self.tolerance_m,
            self.silence,
            self.detection,
        )


@dataclass(frozen=True, slots=True)
class WheelConfig:
    """[[wheel]]: the encoder of a wheel that is driven, or steered."""

    name: Literal["left", "right", "drive", "steering"]
    driver: str
    bus: str
    gear: float = 1.0
    """Turns of the encoder for one of the wheel; negative if it counts backwards."""
    fastest_rad_s: float = 100.0
    zero_deg: float = 0.0
    """Of steering: what is told, behind the gear, when it is straight ahead."""
    most_deg: float | None = None
    """Of steering: how far it can turn to either side; by default 180, with "ackermann" 80."""
    settings: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        require(1e-4 <= abs(self.gear) <= 1e4, "`gear` must lie in 0.0001...10000, or below 0 as far")
        require(0 < self.fastest_rad_s <= 1e5, "`fastest_rad_s` must lie in 0...100000")
        require(abs(self.zero_deg) <= 36_000, "`zero_deg` must lie in -36000...36000")
        require(self.most_deg is None or 0 < self.most_deg <= 180, "`most_deg` must lie in 0...180")
        for name, value in (("zero_deg", self.zero_deg), ("most_deg", self.most_deg)):
            require(not value or self.name == "steering", f"`{name}` is for the wheel named `steering`")


@dataclass(frozen=True, slots=True)
class GyroConfig:
    """[[gyro]]: the yaw gyro, if there is one."""

    name: str
    driver: str
    bus: str
    turn_error_deg: float = 0.05
    """The standard deviation of its turn after 1 s; it grows with the root of time (angle random walk)."""
    settings: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        plain = self.name.isprintable() and self.name == self.name.strip()
        require(plain, "`name` must be printable, without blanks around it")
        require(0 < self.turn_error_deg <= 90, "`turn_error_deg` must lie in 0...90")
