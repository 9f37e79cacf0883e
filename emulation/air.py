"""The air around a robot: every ranger's ping is heard by the others, too.

What is heard of other pings follows from when who fired where, never from a lottery: the sound of a ping at
t_tx which went a way L arrives at a ranger that fired at t_rx as if from (c/2)(L/c + t_tx - t_rx).
"""

from bisect import bisect_left, insort
from collections.abc import Iterable, Iterator
from operator import attrgetter
from typing import NamedTuple

from echogrid.emulation.acoustics import Transducer, speed_of_sound
from echogrid.emulation.crosstalk import Earshot, Mouth, Way
from echogrid.emulation.detector import Detector
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.ear import farthest
from echogrid.emulation.hearing import Outing, Ranger, scene_of
from echogrid.emulation.reflectors import Pose, Station
from echogrid.emulation.scene import Echo, Kind
from echogrid.emulation.vista import TOUCH

_MEMORY_NS = 1_000_000_000
"""Longer than any ranger listens, and any sound lasts."""
_SECOND_NS = 1_000_000_000
_FARTHEST = 100.0
"""m: nothing is heard from beyond."""
_CROSSTALK = Kind.CROSSTALK.name.lower()
_DISTANCE = attrgetter("distance")
_TIME = attrgetter("at_ns")


class Ping(NamedTuple):
    """A ping as the others hear it."""

    at_ns: int
    ranger: str
    mouth: Mouth
    """Where it was then."""


class Air:
    """Carries the pings of one robot's rangers, and of foreign ones, to all of its rangers."""

    def __init__(self, outing: Outing) -> None:
        self.outing = outing
        self.speed_of_sound = speed_of_sound(outing.world.temperature)
        """m/s."""
        self._pings: list[Ping] = []

    def __len__(self) -> int:
        """How many pings it remembers."""
        return len(self._pings)

    def surroundings(self, ranger: Ranger) -> Surroundings:
        """What one ranger of the robot has around it."""
        member = _Member(self, ranger)
        return Surroundings(member.scene, self.speed_of_sound, member.ambient, member.ping)

    def add_foreign(self, pose: Pose, transducer: Transducer, times_ns: Iterable[int]) -> None:
        """Let a ranger which is not the robot's own stand at a pose (map frame) and fire at these times."""
        mouth = Mouth(Station.at(pose), transducer)
        for at_ns in times_ns:
            insort(self._pings, Ping(at_ns, "", mouth), key=_TIME)

    def put(self, ping: Ping) -> None:
        """Remember a ping, and forget those long before it."""
        insort(self._pings, ping, key=_TIME)
        del self._pings[: bisect_left(self._pings, ping.at_ns - _MEMORY_NS, key=_TIME)]

    def between(self, first_ns: int, last_ns: int) -> list[Ping]:
        """The pings from a time up to another."""
        first = bisect_left(self._pings, first_ns, key=_TIME)
        return self._pings[first : bisect_left(self._pings, last_ns, first, key=_TIME)]


class _Sound(NamedTuple):
    """A ping that may be heard on a way."""

    ping: Ping
    way: Way
    distance: float
    """m: from which it seems to come."""
    loss: float
    """dB."""


class _Member:
    """One ranger among all that share the air."""

    def __init__(self, air: Air, ranger: Ranger) -> None:
        self._air = air
        self._ranger = ranger
        self._own = scene_of(air.outing, ranger)
        transducer = ranger.transducer
        self._detector = Detector(transducer.sensitivity, air.outing.noise(ranger, 1))
        faintest = self._detector.faintest
        lasting = farthest(lambda half_way: transducer.way_loss(half_way) <= faintest, _FARTHEST)
        self._half_window_ns = round(_SECOND_NS * transducer.reach / air.speed_of_sound)
        self._lasting_ns = round(2 * _SECOND_NS * lasting / air.speed_of_sound)

    def ping(self, fire_ns: int) -> None:
        """It fires."""
        station = Station.at(self._air.outing.pose_of(self._ranger, fire_ns))
        self._air.put(Ping(fire_ns, self._ranger.name, Mouth(station, self._ranger.transducer)))

    def scene(self, fire_ns: int) -> tuple[Echo, ...]:
        """What it hears of its own ping, and of the others meanwhile."""
        own, others = self._own(fire_ns), self.ambient(fire_ns)
        return tuple(sorted(own + others, key=_DISTANCE)) if others else own

    def ambient(self, start_ns: int) -> tuple[Echo, ...]:
        """What it hears of other pings, its own earlier ones among them, as if it had fired at a time.

        It listens from where it is in the middle of its listening.
        """
        pings = list(self._audible(start_ns))
        if not pings:
            return ()
        outing, middle_ns = self._air.outing, start_ns + self._half_window_ns
        listener = Mouth(Station.at(outing.pose_of(self._ranger, middle_ns)), self._ranger.transducer)
        earshot = Earshot(outing.moment(start_ns), listener, self._detector.faintest)
        sounds = [sound for ping in pings for sound in self._sounds(ping, start_ns, earshot)]
        margins = self._detector.margins([sound.loss for sound in sounds])
        heard = [
            (Echo(sound.distance, margin, _CROSSTALK), 0.5 * sound.way.length)
            for sound, margin in zip(sounds, margins, strict=True)
            if margin >= 0.0 and earshot.is_open(sound.ping.mouth, sound.way)
        ]
        timed = self._detector.timed([echo for echo, _ in heard], [half_way for _, half_way in heard])
        return tuple(sorted(timed, key=_DISTANCE))

    def _audible(self, start_ns: int) -> Iterator[Ping]:
        """The pings which may come in while it listens, in its band and not missed."""
        last_ns = start_ns + 2 * self._half_window_ns
        for ping in self._air.between(start_ns - self._lasting_ns, last_ns):
            own = ping.at_ns == start_ns and ping.ranger == self._ranger.name
            in_band = self._ranger.transducer.hears(ping.mouth.transducer.frequency)
            if in_band and not own and not self._detector.misses():
                yield ping

    def _sounds(self, ping: Ping, start_ns: int, earshot: Earshot) -> Iterator[_Sound]:
        """The ways on which it may hear a ping in its time."""
        transducer = self._ranger.transducer
        head_start = 0.5 * self._air.speed_of_sound * (start_ns - ping.at_ns) / _SECOND_NS
        for way in earshot.ways_from(ping.mouth):
            distance = 0.5 * way.length - head_start
            if transducer.blanking <= distance <= transducer.reach:
                loss = way.loss + transducer.way_loss(0.5 * way.length)
                loss += transducer.ramp_loss(max(distance, TOUCH))
                if loss <= self._detector.faintest:
                    yield _Sound(ping, way, distance, loss)
