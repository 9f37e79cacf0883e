"""The results file: a line of JSON for each drive, written as soon as it is over."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from echogrid.runtime.errors import UsageError
from echogrid.runtime.trials.job import Job
from echogrid.runtime.trials.verdict import Verdict


@dataclass(frozen=True, slots=True)
class Line:
    """A drive that is over."""

    job: Job
    verdict: Verdict
    cpu_s: float
    """What it cost; of no weight."""

    def text(self) -> str:
        """A line of JSON, without its end."""
        table = {"job": self.job.as_dict(), "verdict": self.verdict.as_dict(), "cpu_s": round(self.cpu_s, 3)}
        return json.dumps(table)

    @classmethod
    def of(cls, table: dict[str, Any]) -> "Line":
        """From what a line holds."""
        return cls(Job(**table["job"]), Verdict.of(table["verdict"]), table["cpu_s"])


class Results:
    """What is known of jobs. Without a path it is kept in memory alone.

    A last line that was cut off, because the campaign was, is dropped: its job is done again.
    """

    def __init__(self, path: Path | None = None) -> None:
        """Raises UsageError if the file holds anything else."""
        self._path = path
        self._lines: dict[Job, Line] = {}
        if path is not None and path.exists():
            self._read(path)

    def __contains__(self, job: Job) -> bool:
        """Whether it is done."""
        return job in self._lines

    def __getitem__(self, job: Job) -> Line:
        """What became of it."""
        return self._lines[job]

    def add(self, line: Line) -> None:
        """Keep a line, on the disk first."""
        if self._path is not None:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            with self._path.open("a", encoding="utf-8") as file:
                file.write(f"{line.text()}\n")
        self._lines[line.job] = line

    def _read(self, path: Path) -> None:
        text = path.read_text(encoding="utf-8")
        whole, _, torn = text.rpartition("\n")
        if torn:
            path.write_text(f"{whole}\n" if whole else "", encoding="utf-8")
        for number, row in enumerate(whole.splitlines(), start=1):
            try:
                line = Line.of(json.loads(row))
            except (ValueError, KeyError, TypeError) as error:
                told = f"{path}:{number}: no result of a trial (give --results another file)"
                raise UsageError([told]) from error
            self._lines[line.job] = line
