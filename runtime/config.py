"""robot.toml as data: one schema for the service and for logs, with the unit in each key's name."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from ipaddress import ip_address
from math import radians
from typing import Any, Literal

from echogrid.mapping.footprint import Footprint
from echogrid.mapping.kinematics import Differential, Tricycle, Wheels
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.sonar_model import MAX_OCCUPIED, NoEcho
from echogrid.mapping.unknown import Unknown
from echogrid.mapping.verification import AGREEMENT


def _require(holds: bool, message: str) -> None:
    if not holds:
        raise ValueError(message)


def _require_outline(corners: Sequence[Sequence[float]]) -> None:
    if not corners:
        return
    alike = all(len(corner) == 2 and max(map(abs, corner)) <= 100 for corner in corners)
    _require(alike, "`footprint` must be a list of [x_m, y_m] in -100...100")
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
            _require(value is None or 0.001 <= value <= 100, f"`{name}` must lie in 0.001...100")
        _require(0.5 <= self.wheel_ratio <= 2, "`wheel_ratio` must lie in 0.5...2")
        _require(0.5 <= self.slip_factor <= 10, "`slip_factor` must lie in 0.5...10")
        _require(0 < self.wheel_error_mm <= 1000, "`wheel_error_mm` must lie in 0...1000")
        _require(0 < self.steering_error_deg <= 90, "`steering_error_deg` must lie in 0...90")
        _require(-40 <= self.air_temperature_c <= 85, "`air_temperature_c` must lie in -40...85")

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
        _require(not self.listen_only or self.kind == "can", "`listen_only` is for CAN buses")


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
        _require(plain, "`name` must be printable, without blanks around it")
        _require(abs(self.x_m) <= 100 and abs(self.y_m) <= 100, "`x_m` and `y_m` must lie in -100...100")
        _require(abs(self.yaw_deg) <= 36_000, "`yaw_deg` must lie in -36000...36000")
        _require(0 < self.half_angle_deg < 90, "`half_angle_deg` must lie between 0 and 90")
        _require(0 <= self.min_m < self.max_m, "`min_m` must be at least 0 and below `max_m`")
        _require(self.max_m <= 100, "`max_m` must be at most 100")
        tolerable = self.tolerance_m is None or 0 < self.tolerance_m <= 10
        _require(tolerable, "`tolerance_m` must be above 0 and at most 10")
        likely = self.detection is None or 0 <= self.detection <= 0.99
        _require(likely, "`detection` must lie in 0...0.99")

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
        _require(1e-4 <= abs(self.gear) <= 1e4, "`gear` must lie in 0.0001...10000, or below 0 as far")
        _require(0 < self.fastest_rad_s <= 1e5, "`fastest_rad_s` must lie in 0...100000")
        _require(abs(self.zero_deg) <= 36_000, "`zero_deg` must lie in -36000...36000")
        _require(self.most_deg is None or 0 < self.most_deg <= 180, "`most_deg` must lie in 0...180")
        for name, value in (("zero_deg", self.zero_deg), ("most_deg", self.most_deg)):
            _require(not value or self.name == "steering", f"`{name}` is for the wheel named `steering`")


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
        _require(plain, "`name` must be printable, without blanks around it")
        _require(0 < self.turn_error_deg <= 90, "`turn_error_deg` must lie in 0...90")


@dataclass(frozen=True, slots=True)
class FiringConfig:
    """[firing]: which rangers fire when, and which of their readings are believed (docs/firing.md)."""

    mode: Literal["groups", "eeruf", "together"] = "groups"
    """Groups in turn; all in each cycle, with delays that change; or all at once."""
    groups: tuple[tuple[str, ...], ...] = ()
    """Those which fire at one time; by default they are put together by their mounting angles."""
    separation_deg: float = 90.0
    """The least angle between two of a group that is put together."""
    gap_ms: float | None = None
    """The time of each group; by default the least that sound and devices need."""
    cycle_ms: float | None = None
    """The time in which all fire once, unless they fire in groups."""
    jitter_ms: float = 0.0
    """Each cycle begins later by up to so much, by chance."""
    listen_every: int = 0
    """Every so many turns a ranger that can only listens; 0: never."""
    general_call: bool = False
    """One command fires all rangers on a bus that obey it."""
    verify: bool | None = None
    """Whether an echo must agree with the one before or after; by default not in groups."""
    agreement_m: float = AGREEMENT
    """How far apart they may be, besides the way that the robot went."""

    def __post_init__(self) -> None:
        in_groups = self.mode == "groups"
        _require(0 < self.separation_deg <= 360, "`separation_deg` must lie in 0...360")
        _require(self.gap_ms is None or 1 <= self.gap_ms <= 10_000, "`gap_ms` must lie in 1...10000")
        _require(self.gap_ms is None or in_groups, '`gap_ms` is for mode = "groups": give `cycle_ms`')
        _require(self.cycle_ms is None or 1 <= self.cycle_ms <= 10_000, "`cycle_ms` must lie in 1...10000")
        _require(
            self.cycle_ms is None or not in_groups, '`cycle_ms` is not for mode = "groups": give `gap_ms`'
        )
        _require(not (self.groups and self.mode == "together"), '`groups` are not for mode = "together"')
        _require(0 <= self.jitter_ms <= 100, "`jitter_ms` must lie in 0...100")
        listens = self.listen_every == 0 or 2 <= self.listen_every <= 1000
        _require(listens, "`listen_every` must be 0 or lie in 2...1000")
        alike = not (self.general_call and self.mode == "eeruf")
        _require(alike, '`general_call` is not for mode = "eeruf": all that obey it would fire at once')
        _require(0 < self.agreement_m <= 10, "`agreement_m` must lie in 0...10")

    @property
    def verifies(self) -> bool:
        """Whether readings are compared."""
        return self.mode != "groups" if self.verify is None else self.verify


@dataclass(frozen=True, slots=True)
class DriveConfig:
    """[drive]: what is asked of the motors, at most."""

    max_speed_mps: float = 0.5
    max_turn_dps: float = 90.0
    acceleration_mps2: float = 0.5
    """Of each wheel, when it speeds up; how it slows down is the controller's own."""

    def __post_init__(self) -> None:
        _require(0 < self.max_speed_mps <= 10, "`max_speed_mps` must lie in 0...10")
        _require(0 < self.max_turn_dps <= 1000, "`max_turn_dps` must lie in 0...1000")
        _require(0 < self.acceleration_mps2 <= 100, "`acceleration_mps2` must lie in 0...100")


@dataclass(frozen=True, slots=True)
class LoopConfig:
    """[loop]"""

    rate_hz: float = 50.0

    def __post_init__(self) -> None:
        _require(1 <= self.rate_hz <= 1000, "`rate_hz` must lie in 1...1000")


@dataclass(frozen=True, slots=True)
class MapConfig:
    """[map]: the long-term map, around the start of the run. Without width and height it is fitted to a log;
    a live run needs them."""

    resolution_m: float = 0.1
    width_m: float | None = None
    height_m: float | None = None
    tolerance_m: float = 0.1
    model: Literal["murphy", "murphy-consistent", "analytical", "empirical"] = "murphy-consistent"
    """Of Bayes and Dempster-Shafer, as is the following."""
    max_occupied: float = MAX_OCCUPIED
    """Max_occ of the book's models."""
    transducer_radius_mm: float | None = None
    """Of the analytical model."""
    transducer_khz: float | None = None
    model_file: str | None = None
    """Of the empirical model: the file beside robot.toml that `echogrid calibrate sensor` wrote."""
    theory: Literal["bayes", "dempster-shafer", "himm", "counting", "calibrated"] = "calibrated"
    no_echo: NoEcho = NoEcho.WEAK
    pose_gap_s: float = 0.5

    def __post_init__(self) -> None:
        _require(0.005 <= self.resolution_m <= 10, "`resolution_m` must lie in 0.005...10")
        _require(0 < self.tolerance_m <= 10, "`tolerance_m` must be above 0 and at most 10")
        _require(0 < self.max_occupied <= 1, "`max_occupied` must be above 0 and at most 1")
        for name, most in (("transducer_radius_mm", 1000), ("transducer_khz", 10_000)):
            value = getattr(self, name)
            _require(value is None or 0 < value <= most, f"`{name}` must be above 0 and at most {most}")
            needed = value is not None or self.model != "analytical"
            _require(needed, f'`{name}` is needed for model = "analytical"')
        filed = self.model_file is not None or self.model != "empirical"
        _require(
            filed, '`model_file` is needed for model = "empirical": `echogrid calibrate sensor` writes it'
        )
        _require((self.width_m is None) == (self.height_m is None), "`width_m` and `height_m` go together")
        for side in (self.width_m, self.height_m):
            _require(side is None or 0 < side <= 10_000, "`width_m` and `height_m` must lie in 0...10000")
        _require(0 < self.pose_gap_s <= 3600, "`pose_gap_s` must lie in 0...3600")


@dataclass(frozen=True, slots=True)
class LocalConfig:
    """[local]: the grid that moves with the robot."""

    resolution_m: float = 0.05
    size_m: float = 6.0
    fade_s: float = 15.0

    def __post_init__(self) -> None:
        _require(0.01 <= self.resolution_m <= 1, "`resolution_m` must lie in 0.01...1")
        _require(self.resolution_m * 10 <= self.size_m <= 50, "`size_m` must hold 10 cells and be at most 50")
        _require(0 < self.fade_s <= 3600, "`fade_s` must lie in 0...3600")


@dataclass(frozen=True, slots=True)
class ObstacleConfig:
    """[obstacle]: the virtual sensor."""

    sectors: int = 16
    horizon_m: float = 2.0
    stop_distance_m: float = 0.5
    stale_s: float = 1.0

    def __post_init__(self) -> None:
        _require(4 <= self.sectors <= 360, "`sectors` must lie in 4...360")
        _require(0 < self.horizon_m <= 25, "`horizon_m` must lie in 0...25")
        _require(self.stop_distance_m > 0, "`stop_distance_m` must be above 0")
        _require(0 < self.stale_s <= 60, "`stale_s` must lie in 0...60")


@dataclass(frozen=True, slots=True)
class AvoidConfig:
    """[avoid]: how far and how fast the robot may go (docs/obstacle-sensor.md)."""

    unknown: Unknown = Unknown.BLOCKED
    """What is made of that which was not seen, or not lately."""
    slow_mps: float = 0.1
    """With unknown = "slow": how fast it is driven into."""
    margin_m: float = 0.05
    """What must be left before an obstacle when the robot stands."""
    deceleration_mps2: float = 0.5
    """How it stops, at least; of the point of the robot that moves fastest."""
    reaction_ms: float = 100.0
    """From a published view to wheels that heed it."""
    skin_m: float = 0.3
    """So near to the footprint cells need not have been seen: the rangers' cones only begin there."""
    known_part: float = 0.25
    """Of what the robot would sweep, so much must have been seen as free, and lately."""

    def __post_init__(self) -> None:
        _require(0 < self.slow_mps <= 10, "`slow_mps` must lie in 0...10")
        _require(0 <= self.margin_m <= 10, "`margin_m` must lie in 0...10")
        _require(0 < self.deceleration_mps2 <= 100, "`deceleration_mps2` must lie in 0...100")
        _require(0 <= self.reaction_ms <= 10_000, "`reaction_ms` must lie in 0...10000")
        _require(0 <= self.skin_m <= 10, "`skin_m` must lie in 0...10")
        _require(0 < self.known_part <= 1, "`known_part` must be above 0 and at most 1")


@dataclass(frozen=True, slots=True)
class OutputConfig:
    """[[output]]: who is told of the obstacle view, and how (docs/obstacle-sensor.md)."""

    type: Literal["unix", "udp", "can"]
    format: Literal["binary", "json"] = "binary"
    """Of datagrams."""
    path: str | None = None
    """Unix: the receiver's socket, relative to the folder of robot.toml."""
    host: str | None = None
    """UDP: the receiver's IP address."""
    port: int | None = None
    bus: str | None = None
    """CAN: the bus."""
    id: int | None = None
    """CAN: the identifier of the heartbeat; the one above it is taken, too."""
    rate_hz: float = 20.0
    """At most; no more than the loop's."""

    def __post_init__(self) -> None:
        for key, owner in _OUTPUT_KEYS.items():
            given = getattr(self, key) is not None
            _require(given or owner != self.type, f'`{key}` is needed for type = "{self.type}"')
            _require(not given or owner == self.type, f'`{key}` is for type = "{owner}"')
        _require(self.format == "binary" or self.type != "can", '`format` is for type = "unix" and "udp"')
        _require(0 < self.rate_hz <= 1000, "`rate_hz` must lie in 0...1000")
        _require(self.host is None or _is_address(self.host), "`host` must be an IP address, not a name")
        _require(self.port is None or 1 <= self.port <= 65535, "`port` must lie in 1...65535")
        _require(self.id is None or 0 <= self.id < 0x1FFF_FFFF, "`id` must lie in 0...0x1FFFFFFE")

    @property
    def label(self) -> str:
        """What it is called in reports."""
        places = {
            "unix": self.path,
            "udp": f"{self.host}:{self.port}",
            "can": f"{self.bus}:{self.id or 0:#x}",
        }
        return f"{self.type}:{places[self.type]}"


_OUTPUT_KEYS = {"path": "unix", "host": "udp", "port": "udp", "bus": "can", "id": "can"}


def _is_address(host: str) -> bool:
    try:
        ip_address(host)
    except ValueError:
        return False
    return True


@dataclass(frozen=True, slots=True)
class Config:
    """All of robot.toml."""

    robot: RobotConfig = field(default_factory=RobotConfig)
    bus: tuple[BusConfig, ...] = ()
    sensor: tuple[SensorConfig, ...] = ()
    wheel: tuple[WheelConfig, ...] = ()
    gyro: tuple[GyroConfig, ...] = ()
    firing: FiringConfig = field(default_factory=FiringConfig)
    drive: DriveConfig = field(default_factory=DriveConfig)
    loop: LoopConfig = field(default_factory=LoopConfig)
    map: MapConfig = field(default_factory=MapConfig)
    local: LocalConfig = field(default_factory=LocalConfig)
    obstacle: ObstacleConfig = field(default_factory=ObstacleConfig)
    avoid: AvoidConfig = field(default_factory=AvoidConfig)
    output: tuple[OutputConfig, ...] = ()
