"""What an emulated ping costs: alone, and among fifteen neighbours that fire within its window."""

from collections.abc import Callable, Iterator
from math import cos, sin, tau

from tests.bench.stopwatch import Row, least_us

from echogrid.emulation.air import Air
from echogrid.emulation.hearing import Outing, Ranger
from echogrid.emulation.transducers import SRF08
from echogrid.emulation.worlds import WORLDS

MS = 1_000_000
TURNS = 40


def rows() -> Iterator[Row]:
    """What is measured."""
    yield Row(
        "an emulated ping of an SRF08 with 15 neighbours in its window",
        least_us(ring(16)),
        "the same ranger alone",
        least_us(ring(1)),
    )


def ring(rangers: int) -> Callable[[], int]:
    """So many around a robot on its way through the office, all firing at once."""
    venue = WORLDS["office"]()
    outing = Outing(venue.world, lambda now_ns: venue.tour.pose(now_ns * 1e-9), 1, 0)

    def work() -> int:
        air = Air(outing)
        angles = [tau * number / rangers for number in range(rangers)]
        members = [
            air.surroundings(Ranger(f"r{angle:.2f}", (0.15 * cos(angle), 0.15 * sin(angle), angle), SRF08))
            for angle in angles
        ]
        for turn in range(TURNS):
            fire_ns = turn * 100 * MS
            for member in members:
                member.ping(fire_ns)
            for member in members:
                member.scene(fire_ns)
        return TURNS * rangers

    return work
