"""The rangers of a robot under way: they fire when it is their turn, and say what they heard."""

import heapq
from collections import deque
from dataclasses import dataclass
from math import inf

from echogrid.drivers.readings import Outcome, RangeReading, classify
from echogrid.emulation.acoustics import speed_of_sound
from echogrid.emulation.air import Air
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.hearing import Outing, scene_of
from echogrid.runtime.loop import SECOND_NS
from echogrid.runtime.trials.rigs import Rig, Seat
from echogrid.runtime.trials.troubles import Trouble, Troubles

_KEPT = 20_000
"""Pings: some three minutes."""


@dataclass(frozen=True, slots=True)
class Fired:
    """A ping of a ranger that works."""

    stamp_ns: int
    seat: int


class Pinging:
    """All rangers of a rig. Its time only rises."""

    def __init__(self, rig: Rig, outing: Outing, troubles: Troubles, *, crosstalk: bool) -> None:
        self.fired: deque[Fired] = deque(maxlen=_KEPT)
        """What was fired by rangers that work, in order."""
        self._seats = rig.seats
        self._troubles = troubles
        self._speed = speed_of_sound(outing.world.temperature)
        air = Air(outing)
        self._hearing = [
            air.surroundings(seat.heard)
            if crosstalk
            else Surroundings(scene_of(outing, seat.heard), self._speed)
            for seat in rig.seats
        ]
        self._turns = [(seat.first_ns, index) for index, seat in enumerate(rig.seats)]
        heapq.heapify(self._turns)
        self._listening: list[tuple[int, int, int]] = []
        """When its reading is there, the seat, and when it fired; a heap."""
        self._stuck: dict[int, RangeReading] = {}

    def advance(self, now_ns: int) -> list[RangeReading]:
        """Fire what is due; the readings that are there by now, in order."""
        while self._turns[0][0] <= now_ns:
            fire_ns, index = self._turns[0]
            heapq.heapreplace(self._turns, (fire_ns + self._seats[index].every_ns, index))
            if self._troubles.of(index) is not Trouble.DEAD:
                self._fire(fire_ns, index)
        readings = []
        while self._listening and self._listening[0][0] <= now_ns:
            _, index, fire_ns = heapq.heappop(self._listening)
            reading = self._told(index, fire_ns)
            if reading is not None:
                readings.append(reading)
        return readings

    def _fire(self, fire_ns: int, index: int) -> None:
        seat = self._seats[index]
        self._hearing[index].ping(fire_ns)
        if self._troubles.works(index):
            self.fired.append(Fired(fire_ns, index))
        listening_ns = round(2 * SECOND_NS * seat.heard.transducer.reach / self._speed)
        heapq.heappush(self._listening, (fire_ns + listening_ns + seat.lag_ns, index, fire_ns))

    def _told(self, index: int, fire_ns: int) -> RangeReading | None:
        """What a ranger says of a ping, if anything."""
        trouble, seat = self._troubles.of(index), self._seats[index]
        echoes = self._hearing[index].scene(fire_ns)
        if trouble is Trouble.DROPOUTS and self._troubles.loses():
            return None
        heard = trouble is not Trouble.SILENT and bool(echoes)
        reading = self._reading(seat, echoes[0].distance if heard else inf, fire_ns)
        return self._stuck_on(index, reading) if trouble is Trouble.STUCK else reading

    def _stuck_on(self, index: int, reading: RangeReading) -> RangeReading:
        """The first echo, whatever is heard now; the truth before it."""
        if reading.outcome is Outcome.ECHO:
            self._stuck.setdefault(index, reading)
        first = self._stuck.get(index, reading)
        return RangeReading(reading.stamp_ns, 0, first.sensor, first.outcome, first.distance)

    def _reading(self, seat: Seat, distance: float, fire_ns: int) -> RangeReading:
        """Stamped at the moment when the sound met the obstacle, or had gone all its reach."""
        ranger = seat.ranger
        outcome, measured = classify(distance, ranger.nearest, ranger.farthest)
        way = distance if outcome in (Outcome.ECHO, Outcome.TOO_CLOSE) else ranger.farthest
        return RangeReading(fire_ns + round(SECOND_NS * way / self._speed), 0, ranger.name, outcome, measured)
