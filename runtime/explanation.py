"""Why a cell is what it is: every ping that spoke of it, from where, and what each one changed."""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from math import ceil, degrees, floor, radians
from typing import Self

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.cone import cast
from echogrid.mapping.grid import GridGeometry, Patch
from echogrid.mapping.long_term_map import LongTermMap
from echogrid.mapping.mapper import Mapper
from echogrid.mapping.pose import Pose, wrap_angle
from echogrid.mapping.pose_buffer import PoseBuffer
from echogrid.mapping.sounding import Sounding
from echogrid.mapping.theory import Theory
from echogrid.runtime import assembly
from echogrid.runtime.config import Config
from echogrid.runtime.errors import UsageError
from echogrid.runtime.recording import Recording

Believed = Callable[[Sounding], Sounding]

DIRECTION = radians(15.0)
"""Pings from directions further apart than that are told as several."""
SURROUNDINGS = 3.0
"""m: how far around a cell a theory may look to judge it, besides an echo's arc."""


@dataclass(frozen=True, slots=True)
class Testimony:
    """What one ping said of the cell."""

    sounding: Sounding
    distance: float
    """m, from the transducer to the cell."""
    bearing: float
    """rad, off the axis."""
    said: str
    """"hit", "miss" or "silence"."""
    before: float
    after: float
    """P(Occupied)."""

    @property
    def change(self) -> float:
        """By how much it changed the probability."""
        return self.after - self.before


class Witness:
    """A theory which takes note of whatever speaks of one cell, and keeps the surroundings that it needs."""

    def __init__(self, theory: Theory, cell: GridGeometry, believed: Believed) -> None:
        """`cell` is a grid of that cell alone; the theory's grid has it, too. `believed` is what the theory
        takes a ping for."""
        self.geometry = theory.geometry
        self.testimonies: list[Testimony] = []
        self._theory = theory
        self._cell = cell
        self._believed = believed
        self._place = theory.geometry.cell(cell.x_centres[0], cell.y_centres[0])

    def update(self, sounding: Sounding) -> Patch | None:
        """Fuse one ping; the patch that it touched, None if it said nothing."""
        cone = cast(self._cell, self._believed(sounding))
        speaks = len(cone.rows) > 0
        before = self.probability if speaks else 0.0
        touched = self._theory.update(sounding)
        if speaks:
            said = "silence" if not cone.echo else "hit" if cone.occupied[0] else "miss"
            here = float(cone.distance[0]), float(cone.bearing[0])
            self.testimonies.append(Testimony(sounding, *here, said, before, self.probability))
        return touched

    def occupancy(self) -> NDArray[np.float32]:
        """The theory's."""
        return self._theory.occupancy()

    def unknown(self) -> NDArray[np.bool_]:
        """The theory's."""
        return self._theory.unknown()

    def copy(self) -> Self:
        """An independent twin."""
        twin = type(self)(self._theory.copy(), self._cell, self._believed)
        twin.testimonies = list(self.testimonies)
        return twin

    @property
    def known(self) -> bool:
        """Whether anything has spoken of the cell."""
        return not self._theory.unknown()[self._place]

    @property
    def probability(self) -> float:
        """P(Occupied) by now; what is heard of its surroundings may change it, too."""
        return float(self._theory.occupancy()[self._place])


def explain(recording: Recording, x: float, y: float, make: Callable[[GridGeometry], Theory]) -> Witness:
    """Fuse all of a recording around a point (m, map frame). Raises UsageError if it has no pose."""
    if not recording.poses:
        raise UsageError(["no usable pose: nothing can be placed", *recording.faults.lines()])
    config = recording.config
    believed = _believed(config)
    cell, window = _around(recording, x, y, believed)
    witness = Witness(make(window), cell, believed)
    poses = PoseBuffer(None, assembly.pose_gap_ns(config))
    long_term = LongTermMap(window, config.map.tolerance_m, lambda _: witness)
    rangers = [sensor.ranger() for sensor in config.sensor]
    mapper = Mapper(rangers, poses, long_term, None, assembly.verifier(config))
    for stamp_ns, pose in recording.poses:
        mapper.add_pose(stamp_ns, pose)
    first_ns, last_ns = recording.poses[0][0], recording.poses[-1][0]
    for _, reading in sorted(recording.ranges, key=lambda entry: entry[1].stamp_ns):
        if first_ns <= reading.stamp_ns <= last_ns:
            mapper.add(reading)
            mapper.advance()
    mapper.finish()
    return witness


def _believed(config: Config) -> Believed:
    """What the configured theory takes a ping for: a sonar model may have a cone of its own."""
    if config.map.theory in ("bayes", "dempster-shafer"):
        return assembly.sonar_model(config).believed
    return lambda sounding: sounding


def _around(
    recording: Recording, x: float, y: float, believed: Believed
) -> tuple[GridGeometry, GridGeometry]:
    """The cell of the map over a point, and a window that holds all which may count there."""
    resolution, tolerance = recording.config.map.resolution_m, recording.config.map.tolerance_m
    soundings = [Sounding(Pose(), sensor.ranger(), None, tolerance) for sensor in recording.config.sensor]
    rangers = [believed(sounding).ranger for sounding in soundings]
    arc = max(2.0 * ranger.half_angle * ranger.farthest for ranger in rangers)
    row, col, reach = floor(y / resolution), floor(x / resolution), ceil((arc + SURROUNDINGS) / resolution)
    cell = GridGeometry(resolution, col * resolution, row * resolution, 1, 1)
    corner = (col - reach) * resolution, (row - reach) * resolution
    return cell, GridGeometry(resolution, *corner, 2 * reach + 1, 2 * reach + 1)


def told(witness: Witness, most: int) -> Iterator[str]:
    """Lines: what the cell is, what spoke of it, and the pings that changed it most, in their order."""
    said = Counter(each.said for each in witness.testimonies)
    if not witness.testimonies:
        yield "no ping has spoken of this cell: it is unknown"
        return
    state = f"P(occupied) = {witness.probability:.3f}" if witness.known else "unknown"
    parts = ", ".join(f"{said[kind]} {kind}" for kind in ("hit", "miss", "silence"))
    yield f"{state}; {len(witness.testimonies)} pings: {parts}; hit from {_directions(witness)} directions"
    yield f"{'time s':>12} {'sensor':14} {'from x, y m':>16} {'read m':>7} {'r m':>6} {'off deg':>7}  said"
    for each in _weightiest(witness.testimonies, most):
        seat, echo = each.sounding.transducer, each.sounding.echo
        yield (
            f"{each.sounding.stamp_ns * 1e-9:12.3f} {each.sounding.ranger.name:14} "
            f"{seat.x:+8.2f},{seat.y:+7.2f} {'-' if echo is None else f'{echo:.2f}':>7} {each.distance:6.2f} "
            f"{degrees(each.bearing):7.1f}  {each.said:7}  {each.before:.3f} -> {each.after:.3f}"
        )


def _weightiest(testimonies: Sequence[Testimony], most: int) -> list[Testimony]:
    by_weight = sorted(range(len(testimonies)), key=lambda index: -abs(testimonies[index].change))
    return [testimonies[index] for index in sorted(by_weight[:most])]


def _directions(witness: Witness) -> int:
    """From how many directions, a cone's width apart, it was hit."""
    apart: list[float] = []
    for each in witness.testimonies:
        yaw = each.sounding.transducer.yaw
        if each.said == "hit" and all(abs(wrap_angle(yaw - other)) > DIRECTION for other in apart):
            apart.append(yaw)
    return len(apart)
