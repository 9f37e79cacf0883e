"""What rangers hear which only listen: other pings than their own, so a measure of the crosstalk there is."""

from collections import Counter
from dataclasses import dataclass, field
from typing import Any

from echogrid.drivers.readings import Outcome, RangeReading


@dataclass(slots=True)
class Listening:
    """Counts of turns without a ping, by sensor."""

    listened: Counter[str] = field(default_factory=Counter)
    heard_foreign: Counter[str] = field(default_factory=Counter)

    def take(self, reading: RangeReading) -> None:
        """Count a reading, if it is one of these."""
        if reading.listened and reading.outcome is not Outcome.INVALID:
            self.listened[reading.sensor] += 1
            self.heard_foreign[reading.sensor] += reading.outcome is not Outcome.NO_ECHO

    def report(self) -> dict[str, Any]:
        """What report.json holds: of each sensor that listened, how often it heard something."""
        return {
            name: {"listened": count, "heard_foreign": self.heard_foreign[name]}
            for name, count in sorted(self.listened.items())
        }
