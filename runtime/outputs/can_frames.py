"""The obstacle view in two CAN frames, for a motor controller; docs/obstacle-sensor.md has the layout."""

from math import floor
from struct import Struct

from echogrid.drivers.bus import CanFrame
from echogrid.mapping.virtual_sensor import ObstacleView
from echogrid.runtime.outputs.quantities import NONE_U16, REASONS, bearing, millimetres, milliseconds

VERSION = 1
MOST_STANDARD = 0x7FF
_WAY = Struct("<BBBBHH")
_NEAREST = Struct("<BBhHH")


def frames(view: ObstacleView, sequence: int, identifier: int) -> tuple[CanFrame, CanFrame]:
    """The heartbeat with stop and limit, and under the next identifier the nearest obstacle. Identifiers are
    extended if the second does not fit into eleven bits."""
    nearest, count = view.nearest, sequence & 0xFF
    limit = min(floor(view.speed_limit * 1e3), NONE_U16 - 1)
    way = _WAY.pack(
        VERSION, count, int(view.stop), REASONS[view.reason], limit, millimetres(view.path.distance)
    )
    around = _NEAREST.pack(
        VERSION, count, bearing(nearest.bearing), millimetres(nearest.nearest), milliseconds(view.age_ns)
    )
    extended = identifier + 1 > MOST_STANDARD
    return CanFrame(identifier, way, extended), CanFrame(identifier + 1, around, extended)
