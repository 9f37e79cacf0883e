"""The keys of a Roboteq controller's channel in a config file."""

from dataclasses import dataclass
from typing import Literal

from echogrid.drivers.limits import require_between
from echogrid.drivers.sdo import SdoRead, object_name

COUNTERS = {"quadrature": 0x2104, "brushless": 0x2105}
"""The absolute ones. The relative ones (2108h, 2109h) lose motion with every reply that is lost, for ever."""
CHANNELS = 3
"""Of the largest controllers."""
MOST_COUNTS = 1e9


@dataclass(frozen=True, slots=True)
class RoboteqSettings:
    """Where a wheel's count comes from."""

    counts_per_turn: float
    """Four times the pulses of a quadrature encoder; of hall sensors six for each pole pair."""
    node: int = 1
    source: Literal["sdo", "variable"] = "sdo"
    """Whether the counter is asked for, or comes in a variable that a script on the controller writes."""
    channel: int = 1
    """Of "sdo": the encoder's, or with brushless the motor's."""
    encoder: Literal["quadrature", "brushless"] = "quadrature"
    """Of "sdo": which counter, that of an encoder or that of the motor's own sensor."""
    poll_ms: int = 20
    """Of "sdo": from request to request."""
    variable: int = 1
    """Of "variable": its number; two go into each TPDO."""
    heartbeat_ms: int = 100
    """From heartbeat to heartbeat of the controller; 0: it sends none."""

    def __post_init__(self) -> None:
        require_between("counts_per_turn", self.counts_per_turn, 1.0, MOST_COUNTS)
        require_between("node", self.node, 1, 127)
        require_between("channel", self.channel, 1, CHANNELS)
        require_between("poll_ms", self.poll_ms, 5, 200)
        require_between("variable", self.variable, 1, 8)
        if self.heartbeat_ms:
            require_between("heartbeat_ms", self.heartbeat_ms, 10, 10_000)

    @property
    def read(self) -> SdoRead:
        """Asks for the counter."""
        return SdoRead(COUNTERS[self.encoder], self.channel)

    @property
    def tpdo(self) -> int:
        """Number of the TPDO that holds the variable."""
        return (self.variable + 1) // 2

    @property
    def counter(self) -> str:
        """What no other wheel on its bus may have: the counter, and whose."""
        name = f"VAR{self.variable}" if self.source == "variable" else object_name(self.read)
        return f"{name} of node {self.node}"
