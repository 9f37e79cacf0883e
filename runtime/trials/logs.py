"""Logs of drives that failed: enough to drive them again, and to see whether it was the same."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path

from echogrid.runtime.errors import UsageError
from echogrid.runtime.trials.job import Job
from echogrid.runtime.trials.paths import begun
from echogrid.runtime.trials.track import COLUMNS, Row
from echogrid.runtime.trials.verdict import Verdict


@dataclass(frozen=True, slots=True)
class Log:
    """A drive, and its rows step by step."""

    job: Job
    verdict: Verdict
    rows: Sequence[Row]


@dataclass(frozen=True, slots=True)
class Replay:
    """A drive that was driven again."""

    log: Log
    verdict: Verdict
    parted_s: float | None
    """When it first went another way; None: nowhere."""

    @property
    def same(self) -> bool:
        """Whether it was the same, to the bit."""
        return self.verdict.digest == self.log.verdict.digest


def write(path: Path, job: Job, verdict: Verdict, rows: Sequence[Row]) -> None:
    """The job and its verdict in the first line, then a line for each step."""
    path.parent.mkdir(parents=True, exist_ok=True)
    head = {"job": job.as_dict(), "verdict": verdict.as_dict(), "columns": COLUMNS}
    lines = [json.dumps(head), *(json.dumps(row) for row in rows)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def read(path: Path) -> Log:
    """A log. Raises UsageError if the file is none."""
    try:
        head, *rows = map(json.loads, path.read_text(encoding="utf-8").splitlines())
        return Log(Job(**head["job"]), Verdict.of(head["verdict"]), [tuple(row) for row in rows])
    except (ValueError, KeyError, TypeError) as error:
        raise UsageError([f"{path}: no log of a trial (they are in the folder of --failures)"]) from error


def replay(path: Path) -> Replay:
    """Drive a log's job again."""
    log = read(path)
    try:
        run = begun(log.job)
    except KeyError as error:
        raise UsageError([f"{path}: there is no {error} any more"]) from error
    verdict = run.done()
    parted = (
        (one or other)[0]
        for one, other in zip_longest(log.rows, run.track.rows, fillvalue=())
        if one != other
    )
    return Replay(log, verdict, next(parted, None))
