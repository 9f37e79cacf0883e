"""--theory: which way of fusing makes a map, of a recording and of a run."""

import json
from pathlib import Path
from typing import Any, get_args, get_type_hints

import numpy as np
import pytest

from echogrid.mapping.analytical_model import Analytical
from echogrid.mapping.sonar_model import Form
from echogrid.mapping.subjective_model import Subjective
from echogrid.mapping.theories import THEORIES
from echogrid.runtime import assembly, recording
from echogrid.runtime.command_line import main
from echogrid.runtime.commands import arguments
from echogrid.runtime.config import Config, MapConfig
from echogrid.runtime.errors import UsageError

from . import recordings

PLAIN = {"occupancy", "unknown", "resolution", "origin"}


def made(folder: Path, *told: str) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """The report and the arrays of a map."""
    assert main(["map", str(folder), "--out", str(folder / "out"), *told]) == 0
    with np.load(folder / "out/map.npz") as arrays:
        return json.loads((folder / "out/report.json").read_text()), dict(arrays)


def configured(folder: Path, lines: str) -> Config:
    robot = recordings.ROBOT.replace("[map]\n", f"[map]\n{lines}\n")
    return recording.read_simple(recordings.write(folder, robot=robot)).config


def test_the_command_line_the_configuration_and_the_table_have_the_same_theories() -> None:
    assert get_args(get_type_hints(MapConfig)["theory"]) == arguments.THEORIES
    assert set(arguments.THEORIES) == set(THEORIES)


@pytest.mark.parametrize("theory", THEORIES)
def test_every_theory_makes_a_map_and_the_report_says_which(tmp_path: Path, theory: str) -> None:
    report, arrays = made(recordings.write(tmp_path / "log"), "--theory", theory)
    assert report["theory"] == theory
    assert report["balances"] is True
    assert report["fused"] > 50
    known = arrays["occupancy"][~arrays["unknown"]]
    assert known.max() > 0.5 > known.min()


def test_dempster_shafer_also_maps_belief_plausibility_and_conflict(tmp_path: Path) -> None:
    folder = recordings.write(tmp_path / "log")
    _, plain = made(folder, "--theory", "bayes")
    _, arrays = made(folder, "--theory", "dempster-shafer")
    assert set(plain) == PLAIN
    assert set(arrays) == PLAIN | {"belief", "plausibility", "conflict"}
    assert np.all(arrays["belief"] <= arrays["plausibility"] + 1e-6)
    assert arrays["conflict"].max() > 0.0
    assert np.array_equal(plain["unknown"], arrays["unknown"])


@pytest.mark.parametrize("theory", ["counting", "calibrated"])
def test_a_theory_with_a_mind_of_its_own_is_not_told_what_silence_means(
    tmp_path: Path, theory: str, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = recordings.write(tmp_path / "log")
    told = ["map", str(folder), "--out", str(tmp_path / "out"), "--theory", theory, "--no-echo", "clear"]
    assert main(told) == 2
    assert "--no-echo is for --theory bayes, dempster-shafer and himm" in capsys.readouterr().err


def test_a_run_s_theory_goes_before_the_configuration_and_its_map_is_that_of_its_log(tmp_path: Path) -> None:
    run = ["run", "--simulate", "--duration", "5s", "--theory", "dempster-shafer"]
    assert main([*run, "--out", str(tmp_path / "live"), "--log", str(tmp_path / "log")]) == 0
    assert json.loads((tmp_path / "live/report.json").read_text())["theory"] == "dempster-shafer"
    made(tmp_path / "log", "--theory", "dempster-shafer")
    assert (tmp_path / "live/map.npz").read_bytes() == (tmp_path / "log/out/map.npz").read_bytes()


def test_the_sonar_model_is_the_configured_one(tmp_path: Path) -> None:
    assert assembly.sonar_model(configured(tmp_path / "a", "")) == Subjective()
    printed = configured(tmp_path / "b", 'model = "murphy"\ntheory = "bayes"\nmax_occupied = 0.9')
    assert assembly.sonar_model(printed) == Subjective(Form.PRINTED, 0.9)
    piston = 'model = "analytical"\ntransducer_radius_mm = 7.5\ntransducer_khz = 40.0'
    found = assembly.sonar_model(configured(tmp_path / "c", piston))
    assert isinstance(found, Analytical)
    assert found.ka == pytest.approx(5.492, abs=1e-3)


def test_dempster_shafer_takes_the_book_s_masses_whatever_bayes_believes(tmp_path: Path) -> None:
    config = configured(tmp_path, 'model = "murphy"\ntheory = "dempster-shafer"')
    assert assembly.sonar_model(config) == Subjective(Form.CONSISTENT)


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ('model = "analytical"', "`transducer_radius_mm` is needed"),
        ('model = "analytical"\ntransducer_radius_mm = 7.5', "`transducer_khz` is needed"),
        ("transducer_khz = 0.0", "`transducer_khz` must be above 0"),
        ("max_occupied = 1.5", "`max_occupied` must be above 0 and at most 1"),
        ('theory = "guess"', "dempster-shafer"),
    ],
)
def test_what_a_model_lacks_is_told(tmp_path: Path, lines: str, message: str) -> None:
    with pytest.raises(UsageError, match=message):
        configured(tmp_path, lines)
