"""A map from a recording, without real time: the very mapping of a live run."""

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter
from typing import Any

from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.ledger import Ledger
from echogrid.mapping.long_term_map import LongTermMap, MapImage
from echogrid.mapping.mapper import Mapper
from echogrid.mapping.pose_buffer import PoseBuffer, PoseMiss
from echogrid.mapping.theory import Theory
from echogrid.runtime import assembly
from echogrid.runtime.errors import UsageError
from echogrid.runtime.ledger_report import account
from echogrid.runtime.recording import Recording
from echogrid.runtime.simple_log import RowFaults


@dataclass(frozen=True, slots=True)
class OfflineMap:
    """A map, and what became of every reading."""

    image: MapImage
    ledger: Ledger
    seconds: float
    """How long the fusing took."""
    theory: str

    def report(self, faults: RowFaults) -> dict[str, Any]:
        """What report.json holds."""
        return {
            **account(self.ledger, 0),
            "rows_skipped": dict(sorted(faults.counts.items())),
            "theory": self.theory,
            "seconds": round(self.seconds, 6),
            "microseconds_per_reading": round(1e6 * self.seconds / max(self.ledger.produced, 1), 3),
        }


def build(recording: Recording, make: Callable[[GridGeometry], Theory] | None = None) -> OfflineMap:
    """Fuse all of a recording; readings which no pose covers are added to its faults. `make` makes the grid;
    None: as configured.

    Raises UsageError when it has no poses, or spans more than a map can hold.
    """
    if not recording.poses:
        raise UsageError(["no usable pose: nothing can be placed", *recording.faults.lines()])
    mapper = _mapper(recording, make or assembly.theory(recording.config))
    first_ns, last_ns = recording.poses[0][0], recording.poses[-1][0]
    started = perf_counter()
    for place, reading in sorted(recording.ranges, key=lambda entry: entry[1].stamp_ns):
        if first_ns <= reading.stamp_ns <= last_ns:
            mapper.add(reading)
            mapper.advance()
        else:
            mapper.refuse(reading, PoseMiss.BEFORE.value)
            recording.faults.add("range outside the pose span", place)
    mapper.finish()
    seconds = perf_counter() - started
    return OfflineMap(mapper.map.render(), mapper.ledger, seconds, recording.config.map.theory)


def _mapper(recording: Recording, make: Callable[[GridGeometry], Theory]) -> Mapper:
    config = recording.config
    poses = PoseBuffer(None, assembly.pose_gap_ns(config))
    long_term = LongTermMap(_area(recording), config.map.tolerance_m, make)
    rangers = (sensor.ranger() for sensor in config.sensor)
    mapper = Mapper(rangers, poses, long_term, None, assembly.verifier(config))
    for stamp_ns, pose in recording.poses:
        mapper.add_pose(stamp_ns, pose)
    return mapper


def _area(recording: Recording) -> GridGeometry:
    """The configured area around the start, or one that holds all that could be seen."""
    area = recording.config.map
    if area.width_m is not None and area.height_m is not None:
        return assembly.centred(recording.poses[0][1], area.width_m, area.height_m, area.resolution_m)
    rangers = [sensor.ranger() for sensor in recording.config.sensor]
    reach = max(abs(r.mount.x) + abs(r.mount.y) + r.farthest for r in rangers) + 2.0 * area.tolerance_m
    xs, ys = ([getattr(pose, axis) for _, pose in recording.poses] for axis in ("x", "y"))
    return assembly.bounded(
        min(xs) - reach, min(ys) - reach, max(xs) + reach, max(ys) + reach, area.resolution_m
    )
