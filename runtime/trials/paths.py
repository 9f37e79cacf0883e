"""From a job to the drive that does it."""

from collections.abc import Callable, Mapping
from typing import Protocol

from echogrid.runtime.trials.byte_drive import ByteDrive
from echogrid.runtime.trials.drive import Drive
from echogrid.runtime.trials.job import Job
from echogrid.runtime.trials.pilots import PILOTS
from echogrid.runtime.trials.track import Track
from echogrid.runtime.trials.verdict import Verdict


class Driven(Protocol):
    """A job under way."""

    @property
    def track(self) -> Track:
        """What happened so far."""
        ...

    def done(self) -> Verdict:
        """Drive until it is over."""
        ...


PATHS: Mapping[str, Callable[[Job], Driven]] = {
    "readings": lambda job: Drive(job, PILOTS),
    "bytes": ByteDrive,
}
"""What goes from the emulated rangers to the robot."""


def begun(job: Job) -> Driven:
    """The drive, at its start. Raises KeyError for a pilot or a path that is not."""
    return PATHS[job.path](job)
