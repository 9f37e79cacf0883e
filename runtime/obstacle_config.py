"""What is made of obstacles, in robot.toml: how they are seen, how they are avoided, and who is told."""

from dataclasses import dataclass
from ipaddress import ip_address
from typing import Literal

from echogrid.mapping.unknown import Unknown
from echogrid.runtime.requirement import require


@dataclass(frozen=True, slots=True)
class ObstacleConfig:
    """[obstacle]: the virtual sensor."""

    sectors: int = 16
    horizon_m: float = 2.0
    stop_distance_m: float = 0.5
    stale_s: float = 1.0

    def __post_init__(self) -> None:
        require(4 <= self.sectors <= 360, "`sectors` must lie in 4...360")
        require(0 < self.horizon_m <= 25, "`horizon_m` must lie in 0...25")
        require(self.stop_distance_m > 0, "`stop_distance_m` must be above 0")
        require(0 < self.stale_s <= 60, "`stale_s` must lie in 0...60")


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
        require(0 < self.slow_mps <= 10, "`slow_mps` must lie in 0...10")
        require(0 <= self.margin_m <= 10, "`margin_m` must lie in 0...10")
        require(0 < self.deceleration_mps2 <= 100, "`deceleration_mps2` must lie in 0...100")
        require(0 <= self.reaction_ms <= 10_000, "`reaction_ms` must lie in 0...10000")
        require(0 <= self.skin_m <= 10, "`skin_m` must lie in 0...10")
        require(0 < self.known_part <= 1, "`known_part` must be above 0 and at most 1")


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
            require(given or owner != self.type, f'`{key}` is needed for type = "{self.type}"')
            require(not given or owner == self.type, f'`{key}` is for type = "{owner}"')
        require(self.format == "binary" or self.type != "can", '`format` is for type = "unix" and "udp"')
        require(0 < self.rate_hz <= 1000, "`rate_hz` must lie in 0...1000")
        require(self.host is None or _is_address(self.host), "`host` must be an IP address, not a name")
        require(self.port is None or 1 <= self.port <= 65535, "`port` must lie in 1...65535")
        require(self.id is None or 0 <= self.id < 0x1FFF_FFFF, "`id` must lie in 0...0x1FFFFFFE")

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
