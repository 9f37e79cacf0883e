"""robot.toml as data: one schema for the service and for logs, with the unit in each key's name."""

from dataclasses import dataclass, field
from typing import Literal

from echogrid.mapping.sonar_model import MAX_OCCUPIED, NoEcho
from echogrid.mapping.verification import AGREEMENT
from echogrid.runtime.hardware_config import BusConfig, GyroConfig, RobotConfig, SensorConfig, WheelConfig
from echogrid.runtime.obstacle_config import AvoidConfig, ObstacleConfig, OutputConfig
from echogrid.runtime.requirement import require


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
        require(0 < self.separation_deg <= 360, "`separation_deg` must lie in 0...360")
        require(self.gap_ms is None or 1 <= self.gap_ms <= 10_000, "`gap_ms` must lie in 1...10000")
        require(self.gap_ms is None or in_groups, '`gap_ms` is for mode = "groups": give `cycle_ms`')
        require(self.cycle_ms is None or 1 <= self.cycle_ms <= 10_000, "`cycle_ms` must lie in 1...10000")
        require(
            self.cycle_ms is None or not in_groups, '`cycle_ms` is not for mode = "groups": give `gap_ms`'
        )
        require(not (self.groups and self.mode == "together"), '`groups` are not for mode = "together"')
        require(0 <= self.jitter_ms <= 100, "`jitter_ms` must lie in 0...100")
        listens = self.listen_every == 0 or 2 <= self.listen_every <= 1000
        require(listens, "`listen_every` must be 0 or lie in 2...1000")
        alike = not (self.general_call and self.mode == "eeruf")
        require(alike, '`general_call` is not for mode = "eeruf": all that obey it would fire at once')
        require(0 < self.agreement_m <= 10, "`agreement_m` must lie in 0...10")

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
        require(0 < self.max_speed_mps <= 10, "`max_speed_mps` must lie in 0...10")
        require(0 < self.max_turn_dps <= 1000, "`max_turn_dps` must lie in 0...1000")
        require(0 < self.acceleration_mps2 <= 100, "`acceleration_mps2` must lie in 0...100")


@dataclass(frozen=True, slots=True)
class LoopConfig:
    """[loop]"""

    rate_hz: float = 50.0

    def __post_init__(self) -> None:
        require(1 <= self.rate_hz <= 1000, "`rate_hz` must lie in 1...1000")


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
        require(0.005 <= self.resolution_m <= 10, "`resolution_m` must lie in 0.005...10")
        require(0 < self.tolerance_m <= 10, "`tolerance_m` must be above 0 and at most 10")
        require(0 < self.max_occupied <= 1, "`max_occupied` must be above 0 and at most 1")
        for name, most in (("transducer_radius_mm", 1000), ("transducer_khz", 10_000)):
            value = getattr(self, name)
            require(value is None or 0 < value <= most, f"`{name}` must be above 0 and at most {most}")
            needed = value is not None or self.model != "analytical"
            require(needed, f'`{name}` is needed for model = "analytical"')
        filed = self.model_file is not None or self.model != "empirical"
        require(
            filed, '`model_file` is needed for model = "empirical": `echogrid calibrate sensor` writes it'
        )
        require((self.width_m is None) == (self.height_m is None), "`width_m` and `height_m` go together")
        for side in (self.width_m, self.height_m):
            require(side is None or 0 < side <= 10_000, "`width_m` and `height_m` must lie in 0...10000")
        require(0 < self.pose_gap_s <= 3600, "`pose_gap_s` must lie in 0...3600")


@dataclass(frozen=True, slots=True)
class LocalConfig:
    """[local]: the grid that moves with the robot."""

    resolution_m: float = 0.05
    size_m: float = 6.0
    fade_s: float = 15.0

    def __post_init__(self) -> None:
        require(0.01 <= self.resolution_m <= 1, "`resolution_m` must lie in 0.01...1")
        require(self.resolution_m * 10 <= self.size_m <= 50, "`size_m` must hold 10 cells and be at most 50")
        require(0 < self.fade_s <= 3600, "`fade_s` must lie in 0...3600")


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
