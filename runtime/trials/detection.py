"""Whether a robot could have heard what it ran into.

It could if, without noise, a ping of a ranger that works would have brought an echo from it: on the last
stretch before the contact, as long as the robot needs to stop and half a metre more. Of a person, who may
step in front of a robot, it must have been so for a second.
"""

from collections.abc import Iterator
from math import hypot

from echogrid.emulation.ear import ear
from echogrid.emulation.hearing import Outing
from echogrid.emulation.plant import Contact, Plant, Touched
from echogrid.emulation.reflectors import Pose, Reflector, Station, direct
from echogrid.emulation.vista import TOUCH
from echogrid.emulation.world import Moment
from echogrid.runtime.loop import SECOND_NS
from echogrid.runtime.trials.pinging import Fired
from echogrid.runtime.trials.rigs import Rig, Seat

STRETCH_M = 0.5
"""Besides the stopping distance."""
IN_VIEW_NS = SECOND_NS
"""So long a person must have been heard."""
_LOST_NS = SECOND_NS // 2
"""Who was not heard for so long went out of view."""
_ON_IT = 10.0 * TOUCH
"""m: a point so near to a surface is of it."""


class Detection:
    """Looks back at the pings of a drive."""

    def __init__(self, rig: Rig, outing: Outing, plant: Plant) -> None:
        self._rig = rig
        self._outing = outing
        self._plant = plant

    def possible(self, contact: Contact, fired: Iterator[Fired]) -> bool:
        """Whether it could have been heard in time; `fired` are the pings, the latest first."""
        if contact.touched.kind == "person":
            return self._in_view(contact, fired)
        stretch = self._rig.drive.stopping_distance(contact.speed) + STRETCH_M
        first_ns = self._plant.when_travelled(contact.travelled - stretch)
        heard = self._heard(contact.touched, _between(fired, first_ns, contact.stamp_ns))
        return any(True for _ in heard)

    def _in_view(self, contact: Contact, fired: Iterator[Fired]) -> bool:
        latest_ns = contact.stamp_ns
        for stamp_ns in self._heard(contact.touched, _between(fired, 0, contact.stamp_ns)):
            if latest_ns - stamp_ns > _LOST_NS:
                return False
            latest_ns = stamp_ns
            if contact.stamp_ns - latest_ns >= IN_VIEW_NS:
                return True
        return False

    def _heard(self, touched: Touched, fired: Iterator[Fired]) -> Iterator[int]:
        """When it could be heard."""
        for ping in fired:
            moment, seat = self._outing.moment(ping.stamp_ns), self._rig.seats[ping.seat]
            if _answers(moment, self._outing.pose_of(seat.heard, ping.stamp_ns), seat, touched):
                yield ping.stamp_ns


def _between(fired: Iterator[Fired], first_ns: int, last_ns: int) -> Iterator[Fired]:
    """Those of a time, the latest first."""
    for ping in fired:
        if ping.stamp_ns < first_ns:
            return
        if ping.stamp_ns <= last_ns:
            yield ping


def _answers(moment: Moment, pose: Pose, seat: Seat, touched: Touched) -> bool:
    """Whether something returns the sound of a ranger at a pose, without noise."""
    transducer = seat.heard.transducer
    keen, station = ear(transducer, transducer.sensitivity), Station.at(pose)
    vista = moment.glimpse_at(*pose, keen)
    return any(
        reflector.distance < seat.ranger.farthest
        and _is_of(reflector, touched, moment)
        and vista.clear((station.x, station.y), (reflector.x, reflector.y))
        for reflector in direct(moment.world, vista, station, keen)
    )


def _is_of(reflector: Reflector, touched: Touched, moment: Moment) -> bool:
    """Whether the point lies on what was touched."""
    x, y, world = reflector.x, reflector.y, moment.world
    if touched.kind == "wall":
        wall = world.everything.walls[touched.number]
        along = wall.along_x * x + wall.along_y * y - wall.first_reached
        across = wall.normal_x * x + wall.normal_y * y - wall.offset
        return abs(across) <= _ON_IT and -_ON_IT <= along <= wall.length + _ON_IT
    posts = world.everything.posts if touched.kind == "post" else moment.people
    post = posts[touched.number]
    return abs(hypot(x - post.x, y - post.y) - post.radius) <= _ON_IT
