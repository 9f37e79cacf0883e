"""Rangers that say the same again and again while the robot moves on."""

from dataclasses import dataclass
from math import hypot

from echogrid.drivers.readings import Outcome, RangeReading
from echogrid.mapping.pose import Pose, wrap_angle

LEAST_READINGS = 10
LEAST_WAY = 3.0
"""m: along a smooth wall the distance may stay the same to the centimetre, but hardly for so long."""
LEAST_TURN = 1.5
"""rad: while the robot turns hardly anything stays at the same distance."""


@dataclass(slots=True)
class _Spell:
    """The same distance in a row."""

    distance: float
    pose: Pose
    readings: int = 1
    way: float = 0.0
    turn: float = 0.0


class StuckWatch:
    """Watches every ranger's echoes against the robot's motion; silence is not watched, as it may be true."""

    def __init__(self) -> None:
        self._spells: dict[str, _Spell] = {}

    def see(self, reading: RangeReading, pose: Pose) -> None:
        """Take a reading, and the robot's pose by then."""
        if reading.listened:
            return
        if reading.outcome is not Outcome.ECHO:
            self._spells.pop(reading.sensor, None)
            return
        spell = self._spells.get(reading.sensor)
        if spell is None or spell.distance != reading.distance:
            self._spells[reading.sensor] = _Spell(reading.distance, pose)
            return
        spell.readings += 1
        spell.way += hypot(pose.x - spell.pose.x, pose.y - spell.pose.y)
        spell.turn += abs(wrap_angle(pose.yaw - spell.pose.yaw))
        spell.pose = pose

    def stuck(self) -> dict[str, float]:
        """The rangers which are stuck, and the distance (m) that they say."""
        return {
            sensor: spell.distance
            for sensor, spell in self._spells.items()
            if spell.readings >= LEAST_READINGS and (spell.way >= LEAST_WAY or spell.turn >= LEAST_TURN)
        }
