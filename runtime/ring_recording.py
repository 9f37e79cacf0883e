"""What a ring of sonars hears on a lap through an emulated world, with poses that are exactly known.

The ring is that of acoustics_check: sixteen sonars of +-15 deg which listen to 5 m, one after the other. It
is to judge ways of making maps, so wheels, drivers and clocks are left out, and all errors but sound's own.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf, radians

from echogrid.drivers.readings import Outcome, classify
from echogrid.emulation.acoustics import Transducer, speed_of_sound
from echogrid.emulation.hearing import Outing, scene_of
from echogrid.emulation.worlds import Venue
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.sounding import Sounding
from echogrid.runtime.acoustics_check import REACH_M, SONAR, SONARS, ring
from echogrid.runtime.loop import SECOND_NS

HALF_ANGLE = radians(15.0)
NEAREST_M = 0.15
TOLERANCE_M = 0.12
GAP_NS = 35_000_000
"""From one ping to the next."""
_STRIDE = 5
"""So many sonars further is the next to fire, 112 deg off the one before; after sixteen pings all have."""
_LATER_NS = 7_000_000
"""A seed's lap begins so much later than that of the seed before: it hears from other places."""


@dataclass(frozen=True, slots=True)
class Sonar:
    """What the ring is made of, and what a map is told of it."""

    transducer: Transducer = SONAR
    half_angle: float = HALF_ANGLE
    """rad."""
    reach: float = REACH_M
    """m: what is heard from further away is not heard."""


POLAROID = Sonar()
"""With that everything is judged."""


@dataclass(frozen=True, slots=True)
class RingPing:
    """A ping of the ring, from where it was when the sound met the obstacle."""

    sounding: Sounding
    """In the map frame; the stamp counts from the tour's start. Without an echo it is when the sound had gone
    all its reach."""
    speed: float
    """m/s, of the robot."""


def record(venue: Venue, seed: int, sonar: Sonar = POLAROID) -> Iterator[RingPing]:
    """The pings of one lap, in their order; a world and a seed give the same bits.

    Obstacles within the blanking distance, of which no map is made, are left out.
    """
    outing = Outing(venue.world, lambda now_ns: venue.tour.pose(now_ns / SECOND_NS), seed)
    speed_of_air = speed_of_sound(venue.world.temperature)
    sonars = ring(sonar.transducer)
    scenes = [scene_of(outing, each) for each in sonars]
    rangers = [
        Ranger(each.name, Pose(*each.mount), sonar.half_angle, NEAREST_M, sonar.reach) for each in sonars
    ]
    for number in range(round(venue.tour.lap_time * SECOND_NS) // GAP_NS):
        index = number * _STRIDE % SONARS
        fired_ns = number * GAP_NS + seed * _LATER_NS
        echoes = scenes[index](fired_ns)
        outcome, distance = classify(echoes[0].distance if echoes else inf, NEAREST_M, sonar.reach)
        if outcome is Outcome.TOO_CLOSE:
            continue
        echo = distance if outcome is Outcome.ECHO else None
        stamp_ns = fired_ns + round((echo or sonar.reach) / speed_of_air * SECOND_NS)
        seat = Pose(*outing.pose_of(sonars[index], stamp_ns))
        speed, _ = venue.tour.twist(stamp_ns / SECOND_NS)
        yield RingPing(Sounding(seat, rangers[index], echo, TOLERANCE_M, stamp_ns), speed)


def soundings(venue: Venue, seed: int, sonar: Sonar = POLAROID) -> list[Sounding]:
    """The pings of one lap as a theory takes them."""
    return [ping.sounding for ping in record(venue, seed, sonar)]
