from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pytest import CaptureFixture, approx, fixture, mark

from echogrid.mapping.bayes import BayesGrid
from echogrid.mapping.calibrated import CalibratedGrid
from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.sonar_model import Form, NoEcho
from echogrid.runtime import assembly, offline
from echogrid.runtime.command_line import main
from echogrid.runtime.explanation import Witness, explain, told
from echogrid.runtime.recording import Recording, read_simple

from .recordings import POSES_HEADER, RANGES_HEADER

ROBOND = Path(__file__).resolve().parents[3] / "shared" / "data" / "udacity"
ROBOT = """
[map]
theory = "bayes"
no_echo = "weak"
[[sensor]]
name = "front"
x_m = 0.0
y_m = 0.0
yaw_deg = 0.0
half_angle_deg = 15.0
min_m = 0.1
max_m = 4.0
"""


def bayes(geometry: GridGeometry) -> BayesGrid:
    return BayesGrid(geometry, 4.6, Form.CONSISTENT, NoEcho.WEAK)


@fixture
def recording(tmp_path: Path) -> Recording:
    """A robot that drives 1 m towards a wall at x = 3.05, and turns away from it."""
    (tmp_path / "robot.toml").write_text(ROBOT)
    poses = [f"{0.1 * i:.1f},{0.05 * i:.2f},0.05,{0.0 if i <= 20 else 1.5}" for i in range(31)]
    (tmp_path / "poses.csv").write_text("\n".join([POSES_HEADER, *poses]) + "\n")
    ranges = [f"{0.2 * i:.1f},front,{3.05 - 0.1 * i:.3f}" for i in range(11)] + ["2.8,front,inf"]
    (tmp_path / "ranges.csv").write_text("\n".join([RANGES_HEADER, *ranges]) + "\n")
    return read_simple(tmp_path)


def test_the_cell_is_what_it_is_in_the_map(recording: Recording) -> None:
    image = offline.build(recording).image
    for x, y in ((3.05, 0.05), (2.0, 0.05), (2.5, 0.35)):
        witness = explain(recording, x, y, bayes)
        assert witness.testimonies[-1].after == approx(float(image.occupancy[image.geometry.cell(x, y)]))


@mark.parametrize("theory", ["bayes", "dempster-shafer"])
@mark.parametrize("y", [0.05, 0.65, 1.05])
def test_a_model_with_a_cone_of_its_own_is_explained_with_that(
    recording: Recording, theory: Literal["bayes", "dempster-shafer"], y: float
) -> None:
    beam: dict[str, Any] = {"model": "analytical", "transducer_radius_mm": 4.0, "transducer_khz": 40.0}
    changed = replace(recording.config.map, theory=theory, **beam)
    recording.config = replace(recording.config, map=changed)
    image = offline.build(recording).image
    witness = explain(recording, 2.95, y, assembly.theory(recording.config))
    assert witness.testimonies
    assert witness.testimonies[-1].after == approx(float(image.occupancy[image.geometry.cell(2.95, y)]))


def test_it_is_so_of_a_theory_that_looks_around_too(recording: Recording) -> None:
    # Off the cells' borders, on which rounding decides.
    poses = [(at_ns, replace(pose, x=pose.x + 0.0137, y=pose.y + 0.0137)) for at_ns, pose in recording.poses]
    settings = replace(recording.config.map, theory="calibrated")
    shifted = replace(recording, config=replace(recording.config, map=settings), poses=poses)
    image = offline.build(shifted).image
    for x, y in ((3.05, 0.05), (2.0, 0.05), (2.5, 0.35)):
        probability = explain(shifted, x, y, CalibratedGrid).probability
        assert probability == approx(float(image.occupancy[image.geometry.cell(x, y)]), abs=1e-6)


def test_every_ping_that_speaks_of_the_cell_testifies_once_and_in_order(recording: Recording) -> None:
    testimonies = explain(recording, 3.05, 0.05, bayes).testimonies
    assert [each.said for each in testimonies] == ["hit"] * 11
    stamps = [each.sounding.stamp_ns for each in testimonies]
    assert stamps == sorted(set(stamps))
    assert all(each.change > 0 for each in testimonies[:3])
    assert [each.distance for each in testimonies] == approx(3.05 - 0.1 * np.arange(11), abs=1e-6)


def test_what_one_ping_changed_the_next_one_finds(recording: Recording) -> None:
    testimonies = explain(recording, 2.0, 0.05, bayes).testimonies
    assert {each.said for each in testimonies} == {"miss"}
    for one, following in pairwise(testimonies):
        assert one.after == following.before


def test_a_cell_of_which_nobody_spoke_is_unknown(recording: Recording) -> None:
    witness = explain(recording, -3.0, 0.0, bayes)
    assert witness.testimonies == []
    assert list(told(witness, 5)) == ["no ping has spoken of this cell: it is unknown"]


def test_the_pings_that_weighed_most_are_told_in_their_order(recording: Recording) -> None:
    lines = list(told(explain(recording, 3.05, 0.05, bayes), 4))
    assert lines[0].startswith("P(occupied) = 0.9")
    assert "11 pings: 11 hit, 0 miss, 0 silence; hit from 1 directions" in lines[0]
    times = [float(line.split()[0]) for line in lines[2:]]
    assert len(times) == 4
    assert times == sorted(times)
    assert all(" front " in line and " hit " in line for line in lines[2:])


def test_a_witness_s_twin_goes_its_own_way(recording: Recording) -> None:
    witness = explain(recording, 3.05, 0.05, bayes)
    twin = witness.copy()
    twin.update(witness.testimonies[0].sounding)
    assert isinstance(twin, Witness)
    assert len(twin.testimonies) == len(witness.testimonies) + 1


@mark.parametrize(("x", "y"), [(1.3, 0.7), (-0.05, -0.15)])
def test_the_window_has_the_cells_of_the_map(recording: Recording, x: float, y: float) -> None:
    window = explain(recording, x, y, bayes).geometry
    row, col = window.cell(x, y)
    assert abs(window.x_centres[col] - x) <= 0.05 + 1e-9
    assert abs(window.y_centres[row] - y) <= 0.05 + 1e-9
    assert window.x / 0.1 == approx(round(window.x / 0.1))


@mark.skipif(not ROBOND.is_dir(), reason=f"the RoboND recording is not at {ROBOND}")
def test_a_cell_of_a_recording_in_another_format_is_explained_too(capsys: CaptureFixture[str]) -> None:
    assert main(["explain", str(ROBOND), "3.0", "0.0", "--format", "robond", "--most", "2"]) == 0
    first, _, *pings = capsys.readouterr().out.splitlines()
    assert first.startswith("P(occupied) = 0.0")
    assert len(pings) == 2


def test_a_recording_in_another_format_without_a_word_is_told_with_the_option(
    tmp_path: Path, capsys: CaptureFixture[str]
) -> None:
    (tmp_path / "measurement.txt").write_text("")
    assert main(["explain", str(tmp_path), "3.0", "0.0"]) == 2
    assert "try --format robond" in capsys.readouterr().err
