"""What an emulated Roboteq controller knows of one of its motors, and how it is configured."""

from collections.abc import Callable
from dataclasses import dataclass
from math import floor, tau

_SLOPE_NS = 5_000_000
"""The speed is the mean over so long."""
_MOST_RPM = 3000
"""To which relative speeds refer: a guess."""
_CHOICES = {
    "encoder": ("quadrature", "brushless"),
    "source": ("sdo", "variable"),
    "mode": ("canopen", "minican"),
    "start": ("auto", "master"),
}


@dataclass(frozen=True, slots=True)
class RoboteqOptions:
    """One channel of a controller, set up for what its driver's `source` needs."""

    node: int = 1
    channel: int = 1
    gear: float = 1.0
    """Turns of the encoder for one of the wheel; negative if it counts backwards."""
    counts_per_turn: float = 2000.0
    encoder: str = "quadrature"
    """Which counter counts; a "quadrature" one is on a brushed controller, which has no other."""
    source: str = "sdo"
    """"variable": a script copies the counter into `variable`, which is sent."""
    variable: int = 1
    mode: str = "canopen"
    period_ms: int = 20
    """From TPDO to TPDO; in MiniCAN the four take turns."""
    heartbeat_ms: int = 100
    start: str = "auto"
    """Whether it is operational by itself, or when its master starts it."""
    origin: int = 0
    """What the counter begins with; a real one begins with 0."""

    def __post_init__(self) -> None:
        for key, choices in _CHOICES.items():
            if getattr(self, key) not in choices:
                raise ValueError(f"{key} {getattr(self, key)!r}: there are {' and '.join(choices)}")
        if not 1 <= self.node <= 127:
            raise ValueError(f"node {self.node} is no CANopen node (1 to 127)")
        if not 1 <= self.channel <= 3:
            raise ValueError(f"channel {self.channel}: a controller has 1 to 3")
        if self.mode == "minican" and self.source == "sdo":
            raise ValueError("mode 'minican' has no SDO: it goes with source 'variable'")
        if not 1 <= self.variable <= (4 if self.mode == "minican" else 8):
            raise ValueError(f"variable {self.variable}: 1 to 8 are sent with 32 bits, in MiniCAN 1 to 4")
        if self.counts_per_turn < 1:
            raise ValueError(f"counts_per_turn {self.counts_per_turn}: an encoder has at least one")
        if not 1 <= self.period_ms <= 10_000:
            raise ValueError(f"period_ms {self.period_ms}: 1 to 10000 ms")
        if not 0 <= self.heartbeat_ms <= 10_000:
            raise ValueError(f"heartbeat_ms {self.heartbeat_ms}: 0 (none) to 10000 ms")

    @property
    def tpdo(self) -> int:
        """Number of the TPDO that holds the variable, two to each."""
        return (self.variable + 1) // 2


class RoboteqCounter:
    """Counts from power-up on, absolutely and since it was asked last."""

    def __init__(self, angle: Callable[[int], float], options: RoboteqOptions) -> None:
        self._angle = angle
        self._options = options
        self._zero = 0.0
        self._told = 0

    def restart(self, now_ns: int) -> None:
        """Begin anew."""
        self._zero = self._angle(now_ns)
        self._told = self._options.origin

    def count(self, now_ns: int) -> int:
        """Wraps as 32 bits do."""
        return _signed(self._count(now_ns))

    def since_asked(self, now_ns: int) -> int:
        """Counts since this was called last: what is told is gone, whether or not anybody hears it."""
        count = self._count(now_ns)
        told, self._told = self._told, count
        return _signed(count - told)

    def rpm(self, now_ns: int) -> int:
        """Of the encoder."""
        turned = self._turns(self._angle(now_ns) - self._angle(now_ns - _SLOPE_NS))
        return round(turned / _SLOPE_NS * 60e9)

    def per_mille(self, now_ns: int) -> int:
        """Of the highest speed."""
        return max(-1000, min(1000, round(1000 * self.rpm(now_ns) / _MOST_RPM)))

    def _count(self, now_ns: int) -> int:
        turns = self._turns(self._angle(now_ns) - self._zero)
        return self._options.origin + floor(turns * self._options.counts_per_turn)

    def _turns(self, radians: float) -> float:
        return radians / tau * self._options.gear


def _signed(count: int) -> int:
    return (count + (1 << 31)) % (1 << 32) - (1 << 31)
