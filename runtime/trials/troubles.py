"""What may be wrong with the rangers during a drive, from its beginning to its end."""

from collections.abc import Mapping
from enum import Enum
from zlib import crc32

import numpy as np

from echogrid.runtime.trials.job import Job

_LOST = 0.3
"""The part of the readings that get lost on a bus with dropouts."""


class Trouble(Enum):
    """How a ranger fails."""

    DEAD = "dead"
    """It does not fire, and says nothing."""
    STUCK = "stuck"
    """It says its first echo again and again."""
    SILENT = "silent"
    """It says that it hears nothing."""
    DROPOUTS = "dropouts"
    """Three in ten of its readings never come."""


FAULTS: Mapping[str, tuple[Trouble | None, int]] = {
    "none": (None, 0),
    "dead": (Trouble.DEAD, 2),
    "stuck": (Trouble.STUCK, 1),
    "silent": (Trouble.SILENT, 1),
    "dropouts": (Trouble.DROPOUTS, 0),
}
"""What fails, and how many neighbours do; 0: all."""


class Troubles:
    """Which ranger fails how; who it is, and which readings are lost, follows from world and seed."""

    def __init__(self, job: Job, seats: int) -> None:
        trouble, count = FAULTS[job.fault]
        self._rng = np.random.default_rng((job.seed, crc32(job.world.encode()), 99))
        first = int(self._rng.integers(seats))
        struck = [(first + more) % seats for more in range(count or seats)]
        self._of: dict[int, Trouble] = dict.fromkeys(struck, trouble) if trouble else {}

    def of(self, seat: int) -> Trouble | None:
        """How that ranger fails, if it does."""
        return self._of.get(seat)

    def works(self, seat: int) -> bool:
        """Whether what it hears is told, by and large."""
        return self._of.get(seat) in (None, Trouble.DROPOUTS)

    def loses(self) -> bool:
        """Whether the next reading of one with dropouts is lost."""
        return bool(self._rng.random() < _LOST)
