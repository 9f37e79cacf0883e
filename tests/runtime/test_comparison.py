from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from echogrid.mapping import probability_scores as scores
from echogrid.mapping.metrics import quality
from echogrid.mapping.pose import Pose
from echogrid.runtime import comparison, map_files, offline, recording, truth_map
from echogrid.runtime.compared_theories import WHAT_IT_IS
from echogrid.runtime.comparison import Comparison, Finding
from echogrid.runtime.comparison_steering import TRUTH
from echogrid.runtime.comparison_tables import JUDGED, Table, alike, as_text, figures, sensitivity, tables
from echogrid.runtime.contenders import narrowed
from echogrid.runtime.echo_tape import EchoTape, play, speed_at
from echogrid.runtime.errors import UsageError
from echogrid.runtime.map_suite import SUREST
from echogrid.runtime.truth_map import TruthMap

from . import recordings

NAMES = tuple(WHAT_IT_IS)
FEW = ("bayes", "himm")


def quiet(_: str) -> None:
    """Says nothing."""


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recordings.write(tmp_path_factory.mktemp("log"))


@pytest.fixture(scope="module")
def truth(log: Path, tmp_path_factory: pytest.TempPathFactory) -> TruthMap:
    """What calibrated evidence makes of the log is taken for true."""
    folder = tmp_path_factory.mktemp("truth")
    map_files.write(folder, offline.build(recording.read_simple(log)).image, [])
    return truth_map.read(folder / "map.npz")


@pytest.fixture(scope="module")
def judged(log: Path, truth: TruthMap) -> Comparison:
    return comparison.compare(recording.read_simple(log), truth, NAMES, quiet)


@pytest.fixture(scope="module")
def unjudged(log: Path) -> Comparison:
    return comparison.compare(recording.read_simple(log), None, NAMES, quiet)


def column(table: Table, title: str) -> dict[str, str]:
    """By the row's name."""
    index = table.header.index(title)
    return {row[0]: row[index] for row in table.rows}


def test_every_theory_is_in_every_table_that_tells_of_theories(judged: Comparison) -> None:
    for table in tables(judged, timing=True)[:4]:
        assert [row[0] for row in table.rows if row[0] != TRUTH] == list(NAMES)
        assert all(len(row) == len(table.header) for row in table.rows)


def test_the_figures_are_those_of_the_functions(judged: Comparison) -> None:
    walls, table = judged.walls, figures(judged, timing=False)
    assert walls is not None
    occupied = walls[judged.judged]
    for found in judged.findings:
        p = found.occupancy[judged.judged]
        sure = p if found.name == "calibrated" else np.clip(p, SUREST, 1.0 - SUREST)
        called = quality((found.occupancy > 0.5) & ~found.unknown, walls, judged.judged)
        due = {
            "score a cell (11.16)": f"{scores.book_score(p, occupied) / len(p):.3f}",
            "AUC": f"{scores.area_under_curve(p, occupied):.3f}",
            "log-loss, nats": f"{scores.log_loss(sure, occupied):.3f}",
            "skill": f"{scores.skill(sure, occupied):.2f}",
            "Brier": f"{scores.brier(p, occupied):.3f}",
            "Pearson r": f"{scores.correlation(p, occupied):.3f}",
            "F1 at .5": f"{called.f1:.3f}",
            "IoU": f"{called.overlap:.3f}",
            "phantoms": f"{called.phantoms:.1%}",
            "missed walls": f"{called.missed:.1%}",
        }
        assert {title: column(table, title)[found.name] for title in due} == due
        assert float(column(table, "best F1")[found.name]) >= round(called.f1, 3)


def test_the_best_of_each_column_is_marked(judged: Comparison) -> None:
    table = figures(judged, timing=False)
    for index, each in enumerate(JUDGED, 1):
        marked = [table.rows[row][index] for row, col in table.best if col == index]
        others = [float(row[index].rstrip("%")) for row in table.rows]
        best = max(others) if each.high_is_good else min(others)
        assert marked
        assert {float(cell.rstrip("%")) for cell in marked} == {best}


def test_only_dempster_shafer_tells_of_conflict(judged: Comparison) -> None:
    told = column(figures(judged, timing=False), "conflict a ping, nats")
    assert [name for name, cell in told.items() if cell != "-"] == ["dempster-shafer"]
    found = {each.name: each for each in judged.findings}["dempster-shafer"]
    assert found.conflict is not None
    assert told["dempster-shafer"] == f"{found.conflict.sum() / judged.pings:.2f}"


def test_without_a_truth_what_needs_it_is_left_out_with_a_word(unjudged: Comparison) -> None:
    table = figures(unjudged, timing=True)
    assert table.header == ("theory", "cells a ping", "conflict a ping, nats", "us a ping")
    assert "--truth" in table.notes[0]
    assert column(sensitivity(unjudged), "number").keys() < set(NAMES)
    assert all(row[1] != "threshold" for row in sensitivity(unjudged).rows)


def test_every_number_of_a_theory_is_turned(judged: Comparison) -> None:
    numbers: dict[str, list[str]] = {}
    for row in sensitivity(judged).rows:
        numbers.setdefault(row[0], []).append(row[1])
    assert numbers["bayes"] == ["beta", "tolerance", "Max_occ", "threshold"]
    assert numbers["himm"] == ["beta", "tolerance", "I+", "I-", "threshold"]
    assert numbers["range-layer"] == ["beta", "tolerance", "phi", "threshold"]
    assert "bayes-by-speed" not in numbers


def test_maps_agree_with_themselves_and_with_others_alike(unjudged: Comparison) -> None:
    r = comparison.agreement(unjudged)
    np.testing.assert_allclose(np.diag(r), 1.0)
    np.testing.assert_allclose(r, r.T)
    one, other = (found.occupancy[unjudged.judged] for found in unjudged.findings[1:3])
    assert r[1, 2] == pytest.approx(np.corrcoef(one, other)[0, 1])


def test_a_map_that_is_flat_but_for_rounding_agrees_with_none(unjudged: Comparison) -> None:
    first, *others = unjudged.findings
    rounding = np.random.default_rng(0).uniform(0.0, 1e-9, first.occupancy.shape)
    flat = replace(first, occupancy=0.3 + rounding)
    r = comparison.agreement(replace(unjudged, findings=(flat, *others)))
    np.testing.assert_array_equal(r[0], 0.0)
    np.testing.assert_array_equal(r[:, 0], 0.0)


def test_maps_of_one_cell_are_compared_without_a_warning(unjudged: Comparison) -> None:
    one = np.zeros_like(unjudged.judged)
    one[tuple(np.argwhere(unjudged.judged)[0])] = True
    np.testing.assert_array_equal(comparison.agreement(replace(unjudged, judged=one)), 0.0)


def test_the_matched_pair_is_told_of_only_when_both_are_there(log: Path, unjudged: Comparison) -> None:
    found = {each.name: each.occupancy[unjudged.judged] for each in unjudged.findings}
    between = np.abs(found["bayes"] - found["dempster-shafer"]).mean()
    assert f"{between:.3f} apart" in alike(unjudged).notes[-1]
    alone = comparison.compare(recording.read_simple(log), None, FEW, quiet)
    assert len(alike(alone).notes) == 1


def test_a_map_that_is_the_same_everywhere_agrees_with_none(unjudged: Comparison) -> None:
    one, other, *_ = unjudged.findings
    flat = replace(other, occupancy=np.full_like(other.occupancy, 0.5))
    r = comparison.agreement(replace(unjudged, findings=(one, flat)))
    assert r[0, 1] == r[1, 0] == 0.0


def same(one: Finding, other: Finding) -> bool:
    return one.occupancy.tobytes() == other.occupancy.tobytes() and one.sways == other.sways


def test_the_same_log_gives_the_same_comparison(log: Path, unjudged: Comparison) -> None:
    again = comparison.compare(recording.read_simple(log), None, NAMES, quiet)
    assert all(same(one, other) for one, other in zip(again.findings, unjudged.findings, strict=True))
    assert tables(again, timing=False) == tables(unjudged, timing=False)


def test_theories_are_chosen_by_name_and_named_while_they_are_at_work(log: Path) -> None:
    said: list[str] = []
    found = comparison.compare(recording.read_simple(log), None, ("himm", "bayes"), said.append)
    assert said == ["bayes", "himm"] == [each.name for each in found.findings]


def test_the_cells_are_the_truth_s(log: Path, truth: TruthMap) -> None:
    moved = replace(truth, geometry=replace(truth.geometry, x=truth.geometry.x + 0.03))
    found = comparison.compare(recording.read_simple(log), moved, FEW, quiet)
    assert (found.geometry.x - moved.geometry.x) / 0.1 == pytest.approx(
        round((found.geometry.x - moved.geometry.x) / 0.1), abs=1e-6
    )


def test_a_truth_of_another_place_is_refused(log: Path, truth: TruthMap) -> None:
    far = replace(truth, geometry=replace(truth.geometry, x=500.0))
    with pytest.raises(UsageError, match="no wall where the log heard anything: is it of another place"):
        comparison.compare(recording.read_simple(log), far, FEW, quiet)


def test_a_truth_of_walls_alone_is_refused(log: Path, truth: TruthMap) -> None:
    with pytest.raises(UsageError, match="no free cell where the log heard anything"):
        comparison.compare(
            recording.read_simple(log), replace(truth, free=np.zeros_like(truth.free)), FEW, quiet
        )


def test_a_log_without_an_echo_is_refused(tmp_path: Path) -> None:
    told = recording.read_simple(recordings.write(tmp_path, ranges=["1.0,front,inf", "2.0,left,nan"]))
    with pytest.raises(UsageError, match="no echo"):
        comparison.compare(told, None, FEW, quiet)


def test_a_log_without_poses_is_refused(log: Path) -> None:
    told = recording.read_simple(log)
    told.poses.clear()
    with pytest.raises(UsageError, match="no usable pose"):
        comparison.compare(told, None, FEW, quiet)


def test_cones_that_cannot_be_wider_by_a_quarter_are_not_turned(tmp_path: Path) -> None:
    robot = recordings.ROBOT.replace("half_angle_deg = 12.0", "half_angle_deg = 80.0")
    told = recording.read_simple(recordings.write(tmp_path, robot=robot))
    found = comparison.compare(told, None, ("bayes",), quiet)
    assert [sway.parameter for sway in found.findings[0].sways] == ["tolerance", "Max_occ"]


def test_the_table_s_columns_are_lined_up() -> None:
    table = Table("Two", ("theory", "r"), (("bayes", "0.5"), ("himm", "10.25")), ("A note.",))
    assert list(as_text(table)) == [
        "## Two",
        "",
        "| theory | r     |",
        "|--------|-------|",
        "| bayes  | 0.5   |",
        "| himm   | 10.25 |",
        "",
        "A note.",
    ]


# The pings of a log


def test_the_tape_holds_what_the_map_is_made_of(log: Path) -> None:
    told = recording.read_simple(log)
    made = offline.build(told)
    area, pings = play(recording.read_simple(log))
    assert area == made.image.geometry
    assert len(pings) == made.ledger.fused
    stamps = [ping.sounding.stamp_ns for ping in pings]
    assert stamps == sorted(stamps)


def test_the_tape_marks_where_echoes_end(log: Path) -> None:
    area, pings = play(recording.read_simple(log))
    tape = EchoTape(area)
    assert tape.unknown().all()
    first = next(ping.sounding for ping in pings if ping.sounding.echo is not None)
    tape.update(first)
    twin = tape.copy()
    end = first.transducer.compose(Pose(first.echo or 0.0))
    assert [tuple(cell) for cell in np.argwhere(~tape.unknown())] == [area.cell(end.x, end.y)]
    assert tape.occupancy()[area.cell(end.x, end.y)] == 1.0
    for ping in pings:
        tape.update(ping.sounding)
    assert np.count_nonzero(~twin.unknown()) == 1


def test_the_speed_is_that_of_the_poses() -> None:
    still = [(step * 100_000_000, Pose(1.0, 2.0, 0.1 * step)) for step in range(10)]
    going = [(step * 100_000_000, Pose(0.03 * step, -0.04 * step)) for step in range(100)]
    stamps = np.array([0, 150_000_000, 5_000_000_000, 9_900_000_000])
    np.testing.assert_allclose(speed_at(still, stamps[:2]), 0.0)
    np.testing.assert_allclose(speed_at(going, stamps), 0.5)


def test_the_cone_narrows_with_speed(log: Path) -> None:
    _, pings = play(recording.read_simple(log))
    standing, fast = (replace(pings[0], speed=speed) for speed in (0.0, 0.5))
    whole = pings[0].sounding.ranger.half_angle
    assert narrowed(0.5, standing).ranger.half_angle == whole
    assert narrowed(0.5, fast).ranger.half_angle == pytest.approx(whole / 3.0)
