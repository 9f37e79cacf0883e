"""What the suite finds, as tables in Markdown: how good each theory's maps are, and how sure that is."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from operator import attrgetter

import numpy as np
from numpy.typing import NDArray

from echogrid.runtime.map_suite import SUREST, Contender, Standings, standings
from echogrid.runtime.paired_bootstrap import paired_bootstrap
from echogrid.runtime.sensitivity import FACTORS, MeanSway, sways
from echogrid.runtime.stationary import ALIKE, CELLS, Moved, moved

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Column:
    """A figure of the table."""

    title: str
    figure: str
    """The field of Verdict."""
    form: str = ".3f"
    high_is_good: bool = True

    def worst(self, by_world: Floats) -> float:
        """Of the means of each world."""
        return float(by_world.min() if self.high_is_good else by_world.max())

    def best(self, means: Iterable[float]) -> float:
        """Of several theories'."""
        return max(means) if self.high_is_good else min(means)


QUALITY = (
    Column("AUC", "auc"),
    Column("F1", "f1"),
    Column("best F1", "best_f1"),
    Column("IoU", "overlap"),
    Column("skill", "skill", ".2f"),
    Column("phantoms", "phantoms", ".1%", high_is_good=False),
    Column("ECE", "calibration_error", high_is_good=False),
    Column("r", "correlation", ".2f"),
)
"""What there are goals for."""
MORE = (
    Column("precision", "precision"),
    Column("recall", "recall"),
    Column("missed walls", "missed", ".1%", high_is_good=False),
    Column("free space", "free_recall", ".1%"),
    Column("AP", "average_precision"),
    Column("Brier", "brier", high_is_good=False),
    Column("log-loss, nats", "nats", high_is_good=False),
    Column("bits", "bits", high_is_good=False),
)
BOOK = (
    Column("score (11.16)", "score", ".0f", high_is_good=False),
    Column("a cell", "score_per_cell", high_is_good=False),
    Column("MapScore", "map_score", ".0f"),
    Column("cells a ping", "cells_per_ping", ".0f", high_is_good=False),
    Column("us a ping", "microseconds_per_ping", ".0f", high_is_good=False),
)
FEWEST_WORLDS = 3
"""From which on a bootstrap over worlds means something."""
COMPARED = tuple(column for column in QUALITY if column.figure in {"auc", "f1", "overlap", "skill"})


def tables(
    worlds: Sequence[str], seeds: Sequence[int], contenders: Sequence[Contender], processes: int = 2
) -> Iterator[str]:
    """All of them; the first seed alone is what the sensitivity is measured with."""
    found = standings(worlds, seeds, contenders, processes)
    trials = f"{len(worlds)} worlds x {len(seeds)} seeds"
    for columns in (QUALITY, MORE, BOOK):
        yield from standing_table(found, columns, trials)
        yield ""
    yield from _note(contenders)
    yield ""
    yield from difference_table(found, contenders)
    yield ""
    yield from stationary_table(contenders, worlds[0])
    yield ""
    yield from sensitivity_table(sways(worlds, seeds[0], contenders, processes))


def standing_table(found: Standings, columns: Sequence[Column], trials: str) -> Iterator[str]:
    """A row for each theory: mean / worst world."""
    yield f"| {trials} | {' | '.join(column.title for column in columns)} |"
    yield "|---|" + "---|" * len(columns)
    for name in found:
        cells = []
        for column in columns:
            by_world = figures(found, name, column).mean(axis=1)
            cells.append(f"{by_world.mean():{column.form}} / {column.worst(by_world):{column.form}}")
        yield f"| {name} | {' | '.join(cells)} |"


def difference_table(found: Standings, contenders: Sequence[Contender]) -> Iterator[str]:
    """A row for each theory that is not of the book: how much it differs from the book's best, and from the
    others that are not."""
    yield f"| theory | less | {' | '.join(column.title for column in COMPARED)} |"
    yield "|---|---|" + "---|" * len(COMPARED)
    book = [contender.name for contender in contenders if contender.of_the_book]
    others = [contender.name for contender in contenders if not contender.of_the_book]
    for index, name in enumerate(others):
        rivals = {"the best of the book": book} if book else {}
        for less, names in (rivals | {other: [other] for other in others[:index]}).items():
            cells = (difference(found, name, names, column) for column in COMPARED)
            yield f"| {name} | {less} | {' | '.join(cells)} |"


def difference(found: Standings, name: str, others: Sequence[str], column: Column) -> str:
    """The difference from whichever of the others is the best, and how likely it is to be chance; of less
    than three worlds nothing can be said about that."""
    best = column.best(float(figures(found, other, column).mean()) for other in others)
    rival = next(other for other in others if float(figures(found, other, column).mean()) == best)
    ours, theirs = figures(found, name, column), figures(found, rival, column)
    if len(ours) < FEWEST_WORLDS:
        return f"{float((ours - theirs).mean()):+{column.form}}"
    d = paired_bootstrap(ours, theirs)
    return f"{d.mean:+{column.form}} ({d.low:+{column.form}} to {d.high:+{column.form}}), p = {d.p:.2g}"


def stationary_table(contenders: Sequence[Contender], world: str) -> Iterator[str]:
    """A row for each theory: P(Occupied) of some cells after 1, 3 and many pings."""
    yield f"| P(Occupied) after 1 / 3 / {ALIKE} alike | {' | '.join(CELLS)} | {ALIKE} alike say |"
    yield "|---|" + "---|" * (len(CELLS) + 1)
    for contender in contenders:
        moves = [moved(contender, world, cell) for cell in CELLS.values()]
        after = " | ".join(f"{each.once:.3f} / {each.thrice:.3f} / {each.alike:.3f}" for each in moves)
        yield f"| {contender.name} | {after} | {_said(moves)} |"


def sensitivity_table(found: Sequence[MeanSway]) -> Iterator[str]:
    """A row for each theory and parameter."""
    factors = " | ".join(f"{factor - 1.0:+.0%}" for factor in FACTORS)
    yield f"| change of F1 | parameter | {factors} | largest | in a single world |"
    yield "|---|---|" + "---|" * (len(FACTORS) + 2)
    for s in found:
        changes = " | ".join(f"{change:+.3f}" for change in s.changes)
        yield f"| {s.theory} | {s.parameter} | {changes} | {s.largest:.3f} | {s.worst_world:.3f} |"


def figures(found: Standings, name: str, column: Column) -> Floats:
    """(worlds, seeds) of one theory."""
    figure = attrgetter(column.figure)
    return np.array([[figure(verdict) for verdict in row] for row in found[name]])


def _note(contenders: Sequence[Contender]) -> Iterator[str]:
    calm = ", ".join(each.name for each in contenders if not each.saturates) or "none"
    yield "Each figure: the mean of all trials / the worst world's mean. For log-loss, skill and MapScore the"
    yield f"probabilities of theories that saturate are kept {SUREST:g} from 0 and 1; these do not: {calm}."


def _said(moves: Sequence[Moved]) -> str:
    if all(each.as_once for each in moves):
        return "as much as 1"
    return "no more than 3" if all(each.within_three for each in moves) else "more than 3"
