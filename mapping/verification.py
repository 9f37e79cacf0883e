"""Comparison of consecutive readings: what is heard of others changes from ping to ping, an echo stays.

Of EERUF (Borenstein & Koren 1995): when rangers fire with delays that change from cycle to cycle, the sound
of another one seems to come from c/2 * dt nearer or farther each time. The book believes a reading which
agrees with the one before. Here the one after it will do, too: what is seen for the first time is believed
one ping later, and one false reading no longer takes the next true one with it.
"""

from dataclasses import dataclass
from math import hypot

from echogrid.drivers.readings import Outcome
from echogrid.mapping.placed_ping import PlacedPing

AGREEMENT = 0.10
"""m: two standard deviations of the difference of two readings, at a few metres."""
OLDEST_NS = 3_000_000_000
"""Readings further apart are not compared. The slowest rangers tell one a second: two of them may be lost."""


@dataclass(frozen=True, slots=True)
class Verdict:
    """What a reading decides."""

    verified: tuple[PlacedPing, ...] = ()
    """In the order of their stamps."""
    refused: tuple[PlacedPing, ...] = ()


class Verifier:
    """Takes placed pings, of each sensor in the order of stamps.

    An echo, or what is too close, is verified when it agrees with the sensor's reading before or after it;
    for the latter it waits. Silence and faults pass, for crosstalk adds sounds and takes none away; and they
    agree with no echo.
    """

    def __init__(self, agreement: float = AGREEMENT) -> None:
        """`agreement` is how far apart (m) two readings may be, besides the way that the transducer moved."""
        self._agreement = agreement
        self._latest: dict[str, PlacedPing] = {}
        self._waiting: dict[str, PlacedPing] = {}

    @property
    def waiting(self) -> int:
        """How many pings wait for the next of their sensor."""
        return len(self._waiting)

    def take(self, ping: PlacedPing) -> Verdict:
        """What becomes of this ping, and of the one that waited for it."""
        sensor = ping.reading.sensor
        before, waited = self._latest.get(sensor), self._waiting.pop(sensor, None)
        self._latest[sensor] = ping
        agrees = before is not None and self._agree(before, ping)
        held = (waited,) if waited else ()
        if agrees or heard_at(ping) is None:
            return Verdict((*held, ping)) if agrees else Verdict((ping,), held)
        self._waiting[sensor] = ping
        return Verdict(refused=held)

    def finish(self) -> tuple[PlacedPing, ...]:
        """Those for which no next reading came: refused."""
        refused = tuple(self._waiting.values())
        self._waiting.clear()
        return refused

    def _agree(self, before: PlacedPing, after: PlacedPing) -> bool:
        """|r_i - r_(i-1)| < T, where T is v * T_cycle by the way that was truly gone, and 2 sigma."""
        one, other = heard_at(before), heard_at(after)
        if one is None or other is None or after.reading.stamp_ns - before.reading.stamp_ns > OLDEST_NS:
            return False
        here, there = before.transducer, after.transducer
        return abs(other - one) <= self._agreement + hypot(there.x - here.x, there.y - here.y)


class Believer:
    """In the place of a Verifier where readings need not be compared: all are verified at once."""

    waiting = 0

    def take(self, ping: PlacedPing) -> Verdict:
        """It is verified."""
        return Verdict((ping,))

    def finish(self) -> tuple[PlacedPing, ...]:
        """None has waited."""
        return ()


def heard_at(ping: PlacedPing) -> float | None:
    """The distance (m) of what was heard, if anything was; what is too close is at the blanking distance."""
    if ping.reading.outcome is Outcome.TOO_CLOSE:
        return ping.ranger.nearest
    return ping.reading.distance if ping.reading.outcome is Outcome.ECHO else None
