"""What `echogrid compare` found, as tables of text."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from math import degrees, isnan
from operator import attrgetter

from echogrid.mapping.pose import wrap_angle
from echogrid.runtime.compared_theories import MATCHED
from echogrid.runtime.comparison import Comparison, Finding, agreement, apart
from echogrid.runtime.comparison_steering import AHEAD_M, EVERY_M, TRUTH, Outcome, Steered
from echogrid.runtime.map_table import Column
from echogrid.runtime.sensitivity import FACTORS
from echogrid.runtime.stationary import ALIKE, CELLS

JUDGED = (
    Column("score a cell (11.16)", "score_per_cell", high_is_good=False),
    Column("AUC", "auc"),
    Column("log-loss, nats", "nats", high_is_good=False),
    Column("skill", "skill", ".2f"),
    Column("Brier", "brier", high_is_good=False),
    Column("Pearson r", "correlation"),
    Column("F1 at .5", "f1"),
    Column("best F1", "best_f1"),
    Column("IoU", "overlap"),
    Column("phantoms", "phantoms", ".1%", high_is_good=False),
    Column("missed walls", "missed", ".1%", high_is_good=False),
)
"""What only the truth can tell."""
CELLS_A_PING = Column("cells a ping", "cells_per_ping", ".0f", high_is_good=False)
TIME = Column("us a ping", "microseconds_per_ping", ".0f", high_is_good=False)
CONFLICT = "conflict a ping, nats"
NONE = "-"
UNSEEN_M = 0.3
"""A wall that is so much nearer than the map says was not seen."""


@dataclass(frozen=True, slots=True)
class Table:
    """Rows of text beneath a header; the first column names the row."""

    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    notes: tuple[str, ...] = ()
    best: frozenset[tuple[int, int]] = frozenset()
    """Row and column of the best figures."""


def tables(comparison: Comparison, timing: bool) -> tuple[Table, ...]:
    """All of them. `timing`: with the microseconds, which no two runs have alike."""
    return (
        figures(comparison, timing),
        alike(comparison),
        *([steering(comparison.steered)] if comparison.steered.places else []),
        stationary(comparison),
        sensitivity(comparison),
    )


def figures(comparison: Comparison, timing: bool) -> Table:
    """A row for each theory."""
    columns = [*(JUDGED if comparison.walls is not None else ()), CELLS_A_PING]
    found = comparison.findings
    rows = []
    for finding in found:
        row = [finding.name, *(_cell(finding, column) for column in columns), _conflict(finding, comparison)]
        rows.append((*row, *([_cell(finding, TIME)] if timing else [])))
    best = {
        (row, col)
        for col, column in enumerate(columns, 1)
        for row, finding in enumerate(found)
        if _value(finding, column) == _best(found, column)
    }
    titles = (column.title for column in columns)
    header = ("theory", *titles, CONFLICT, *([TIME.title] if timing else []))
    return Table("The maps", header, tuple(rows), tuple(_judged_by(comparison)), frozenset(best))


def alike(comparison: Comparison) -> Table:
    """How alike the theories' maps are: Pearson's r of each with each."""
    names = tuple(finding.name for finding in comparison.findings)
    rows = tuple(
        (name, *(f"{r:.3f}" for r in row)) for name, row in zip(names, agreement(comparison), strict=True)
    )
    notes = ["Pearson's r of each map with each, over the judged cells."]
    if (between := apart(comparison, *MATCHED)) is not None:
        notes.append(
            f"{' and '.join(MATCHED)} are a matched pair: of each ping both believe the same; how they "
            f"combine it differs. Their maps are {between:.3f} apart on the mean over the cells."
        )
    return Table("How alike they are", ("Pearson r", *names), rows, tuple(notes))


def steering(steered: Steered) -> Table:
    """What a planner would run into: a row for each map, the true one first."""
    true = steered.outcomes.get(TRUTH)
    header = ["map", "no way", "off the goal, deg", "free by the map, m"]
    if true:
        header += ["off the true choice, deg", "free in truth, m", "least", "walls not seen"]
    rows = []
    for name, outcomes in steered.outcomes.items():
        row = [name, _part(each.heading is None for each in outcomes)]
        row += [_mean_deg(outcomes, [place.goal.bearing for place in steered.places])]
        row += [_mean([each.promised for each in outcomes])]
        if true:
            free = [each.free for each in outcomes if each.free is not None]
            row += [_mean_deg(outcomes, [each.heading for each in true]), _mean(free)]
            row += [f"{min(free):.2f}" if free else NONE, _part(map(_unseen, outcomes))]
        rows.append(tuple(row))
    return Table("What steering would decide", tuple(header), tuple(rows), tuple(_steered_by(steered)))


def stationary(comparison: Comparison) -> Table:
    """What a robot makes itself believe by standing still."""
    rows = []
    for finding in comparison.findings:
        after = [f"{each.once:.3f} / {each.thrice:.3f} / {each.alike:.3f}" for each in finding.stationary]
        as_once = all(each.as_once for each in finding.stationary)
        within = all(each.within_three for each in finding.stationary)
        said = "as much as 1" if as_once else "no more than 3" if within else "more than 3"
        rows.append((finding.name, *after, said))
    notes = (
        f"P(Occupied) of a cell after 1 ping / 3 from directions 40 deg apart / {ALIKE} alike from one spot.",
        "The pings are made up, not the log's.",
    )
    return Table("A robot that stands", ("theory", *CELLS, f"{ALIKE} alike say"), tuple(rows), notes)


def sensitivity(comparison: Comparison) -> Table:
    """What depends on numbers that somebody chose."""
    true = comparison.walls is not None
    form = "+.3f" if true else ".3f"
    rows = tuple(
        (
            sway.theory,
            sway.parameter,
            *(f"{change:{form}}" for change in sway.changes),
            f"{sway.largest:.3f}",
        )
        for finding in comparison.findings
        for sway in finding.sways
    )
    what = "How F1 at .5 changes" if true else "How far P(Occupied) of a judged cell is moved, on the mean,"
    notes = (
        f"{what} with each number a quarter lower and higher; Max_occ can't be more than 1.",
        "I+ and I- are what HIMM adds and takes; what growth does, its own row tells.",
    )
    header = ("theory", "number", *(f"{factor - 1.0:+.0%}" for factor in FACTORS), "most")
    return Table("What depends on chosen numbers", header, rows, notes)


def as_text(table: Table) -> Iterator[str]:
    """Lines: the table in Markdown, its columns lined up, and the notes."""
    rows = [table.header, *table.rows]
    widths = [max(len(row[col]) for row in rows) for col in range(len(table.header))]
    yield f"## {table.title}"
    yield ""
    yield _line(table.header, widths)
    yield "|" + "|".join("-" * (width + 2) for width in widths) + "|"
    for row in table.rows:
        yield _line(row, widths)
    for note in table.notes:
        yield ""
        yield note


def _mean(values: Iterable[float | None]) -> str:
    known = [value for value in values if value is not None]
    return f"{sum(known) / len(known):.2f}" if known else NONE


def _part(said: Iterable[bool]) -> str:
    answers = list(said)
    return f"{sum(answers) / len(answers):.0%}"


def _mean_deg(outcomes: Sequence[Outcome], others: Sequence[float | None]) -> str:
    """How far the headings are off others, where both are there."""
    apart = [
        abs(degrees(wrap_angle(each.heading - other)))
        for each, other in zip(outcomes, others, strict=True)
        if each.heading is not None and other is not None
    ]
    return f"{sum(apart) / len(apart):.0f}" if apart else NONE


def _unseen(outcome: Outcome) -> bool:
    if outcome.free is None or outcome.promised is None:
        return False
    return outcome.free < outcome.promised - UNSEEN_M


def _steered_by(steered: Steered) -> Iterator[str]:
    yield (
        f"VFH+ at {len(steered.places)} places of the robot's way, {EVERY_M:g} m apart, each time by the map "
        f"of the whole log, to where the robot was {AHEAD_M:g} m later. No way: it stops where that went."
    )
    yield "Free is how far the robot's disc can go straight along the heading; no farther than the window."
    if TRUTH in steered.outcomes:
        yield f"Walls not seen: a wall ends the heading, {UNSEEN_M:g} m and more before the map says so."


def _line(cells: Sequence[str], widths: Sequence[int]) -> str:
    return f"| {' | '.join(cell.ljust(width) for cell, width in zip(cells, widths, strict=True))} |"


def _judged_by(comparison: Comparison) -> Iterator[str]:
    cells = int(comparison.judged.sum())
    if comparison.walls is None:
        yield "There is no truth (--truth): what needs one is left out; how alike the maps are is told below."
        yield f"Looked at are {cells} cells: those of which at least one echo spoke."
        return
    walls = int((comparison.walls & comparison.judged).sum())
    yield f"Judged are {cells} cells, {walls} of them walls: of which at least one echo spoke, and the truth."
    yield (
        "A hit is within one cell of a wall, a phantom further than two from any. What is unknown counts as "
        "0.5. For log-loss and skill all but the calibrated map's probabilities are kept 0.01 from 0 and 1."
    )


def _value(finding: Finding, column: Column) -> float:
    value: float = attrgetter(column.figure)(finding.verdict)
    return value


def _cell(finding: Finding, column: Column) -> str:
    value = _value(finding, column)
    return NONE if isnan(value) else f"{value:{column.form}}"


def _best(found: Sequence[Finding], column: Column) -> float:
    return column.best(value for finding in found if not isnan(value := _value(finding, column)))


def _conflict(finding: Finding, comparison: Comparison) -> str:
    if finding.conflict is None:
        return NONE
    return f"{float(finding.conflict.sum()) / comparison.pings:.2f}"
