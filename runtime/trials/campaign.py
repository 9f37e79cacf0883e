"""Many drives, side by side in several processes; what was done already is not done again."""

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from time import process_time

from echogrid.runtime.trials import logs
from echogrid.runtime.trials.job import Job
from echogrid.runtime.trials.paths import begun
from echogrid.runtime.trials.results import Line, Results


@dataclass(frozen=True, slots=True)
class Plan:
    """What is to be tried."""

    worlds: Sequence[str]
    pilots: Sequence[str]
    seeds: Sequence[int]
    rig: str = "ring-16"
    fault: str = "none"
    crosstalk: bool = False
    path: str = "readings"

    def jobs(self) -> Iterator[Job]:
        """All drives; those in one world come one after the other."""
        for world in self.worlds:
            for seed in self.seeds:
                for pilot in self.pilots:
                    yield Job(world, seed, pilot, self.rig, self.fault, self.crosstalk, self.path)


def drive(job: Job, failures: Path | None = None) -> Line:
    """Do a job; if it fails its log is written into the folder `failures`."""
    started = process_time()
    run = begun(job)
    verdict = run.done()
    if failures is not None and verdict.failed:
        logs.write(failures / f"{job.name}.jsonl", job, verdict, run.track.rows)
    return Line(job, verdict, process_time() - started)


def run(
    jobs: Sequence[Job],
    results: Results,
    *,
    processes: int,
    failures: Path | None = None,
    told: Callable[[Line], None] = lambda _: None,
) -> None:
    """Do the jobs that the results do not have yet, and add them as they are done."""
    due = [job for job in jobs if job not in results]
    if processes == 1:
        for job in due:
            _add(drive(job, failures), results, told)
        return
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    with ProcessPoolExecutor(processes, get_context("spawn")) as pool:
        futures = [pool.submit(partial(drive, failures=failures), job) for job in due]
        for future in as_completed(futures):
            _add(future.result(), results, told)


def _add(line: Line, results: Results, told: Callable[[Line], None]) -> None:
    results.add(line)
    told(line)
