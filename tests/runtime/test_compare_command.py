import argparse
from collections.abc import Callable
from pathlib import Path

import pytest

from echogrid.runtime.command_line import main
from echogrid.runtime.commands.compare import out, theories
from echogrid.runtime.compared_theories import WHAT_IT_IS
from echogrid.runtime.grey_image import read_grey

from . import recordings

ROBOND = Path(__file__).resolve().parents[3] / "shared" / "data" / "udacity"
Told = Callable[..., tuple[int, str, str]]


@pytest.fixture
def told(capsys: pytest.CaptureFixture[str]) -> Told:
    """Exit code, results and messages."""

    def run(*arguments: str | Path) -> tuple[int, str, str]:
        code = main(["compare", *map(str, arguments)])
        said, err = capsys.readouterr()
        return code, said, err

    return run


@pytest.fixture
def log(tmp_path: Path) -> Path:
    return recordings.write(tmp_path / "log")


def test_theories_are_named_with_commas_between() -> None:
    assert theories("himm, bayes") == ("himm", "bayes")


@pytest.mark.parametrize("text", ["", "bays", "bayes,", "bayes himm"])
def test_a_theory_that_is_not_is_refused_with_the_names_of_those_that_are(text: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError, match=r"no theory is called .*dempster-shafer"):
        theories(text)


def test_a_file_of_no_kind_that_can_be_written_is_refused() -> None:
    with pytest.raises(argparse.ArgumentTypeError, match="neither"):
        out("report.pdf")


def test_the_same_log_gives_the_same_report_but_for_the_time(told: Told, log: Path, tmp_path: Path) -> None:
    chosen = ("--theories", "bayes,dempster-shafer", "--no-timing")
    runs = [told(log, "--out", tmp_path / name / "a.html", *chosen) for name in ("one", "two")]
    assert runs[0] == runs[1]
    assert runs[0][0] == 0
    assert (tmp_path / "one/a.html").read_bytes() == (tmp_path / "two/a.html").read_bytes()
    assert "us a ping" not in runs[0][1]
    assert "us a ping" in told(log, "--theories", "himm")[1]


def test_the_tables_of_the_report_are_those_that_are_printed(told: Told, log: Path, tmp_path: Path) -> None:
    _, said, _ = told(log, "--out", tmp_path / "a.html", "--theories", "bayes,himm", "--no-timing")
    page = (tmp_path / "a.html").read_text()
    rows = [line.split("|")[1:-1] for line in said.splitlines() if line.startswith(("| bayes", "| himm"))]
    assert len(rows) > 10
    for cells in rows:
        assert all(f">{cell.strip()}</t" in page for cell in cells)


def test_a_picture_alone_can_be_had(told: Told, log: Path, tmp_path: Path) -> None:
    for count, names in (("one", "counting"), ("four", "counting,himm,bayes,calibrated")):
        assert told(log, "--out", tmp_path / f"{count}.png", "--theories", names)[0] == 0
    one, four = (read_grey((tmp_path / f"{count}.png").read_bytes()).shape for count in ("one", "four"))
    assert four[0] > one[0]


def test_a_map_of_the_log_is_as_good_a_truth_as_any(told: Told, log: Path, tmp_path: Path) -> None:
    main(["map", str(log), "--out", str(tmp_path / "map"), "--theory", "bayes"])
    said = [
        told(log, "--truth", tmp_path / "map" / name, "--theories", "bayes", "--no-timing")[1]
        for name in ("map.yaml", "map.npz")
    ]
    row = next(line for line in said[1].splitlines() if line.startswith("| bayes"))
    assert [cell.strip() for cell in row.split("|")][3] == "1.000"
    assert all("AUC" in text and "walls" in text for text in said)


@pytest.mark.parametrize(
    ("arguments", "due"),
    [
        (("--truth", "gone.yaml"), "gone.yaml: no such file"),
        (("--truth", "emulated"), "the log's path is"),
        (("--truth", "{coarse}"), "the truth has cells of 0.2 m, the log's map of 0.1 m"),
    ],
)
def test_a_truth_of_no_use_is_2_and_one_line(
    told: Told, log: Path, tmp_path: Path, arguments: tuple[str, ...], due: str
) -> None:
    coarse = tmp_path / "coarse"
    assert main(["map", str(log), "--out", str(coarse), "--resolution", "0.2"]) == 0
    told("--help")
    asked = [each.replace("{coarse}", f"{coarse}/map.npz") for each in arguments]
    code, said, err = told(log, *asked, "--out", tmp_path / "a.html")
    assert (code, said) == (2, "")
    assert due in err
    assert len(err.splitlines()) == 1
    assert not (tmp_path / "a.html").exists()


def test_a_log_without_a_usable_pose_is_2(told: Told, tmp_path: Path) -> None:
    code, _, err = told(recordings.write(tmp_path, poses=[]))
    assert (code, err) == (2, "no usable pose: nothing can be placed\n")


def test_an_unknown_theory_is_2(told: Told, log: Path) -> None:
    code, _, err = told(log, "--theories", "bayes,voodoo")
    assert code == 2
    assert "no theory is called 'voodoo'" in err.splitlines()[-1]


def test_a_simulated_log_is_judged_by_the_office(told: Told, simulated: Path) -> None:
    code, said, _ = told(simulated / "log", "--truth", "emulated", "--theories", "bayes,himm", "--no-timing")
    assert code == 0
    assert "AUC" in said


@pytest.mark.skipif(not ROBOND.is_dir(), reason=f"the RoboND recording is not at {ROBOND}")
def test_every_theory_runs_on_a_real_recording(told: Told, tmp_path: Path) -> None:
    folder = tmp_path / "a hundred scans"
    folder.mkdir()
    for name in ("measurement.txt", "poses.txt"):
        lines = (ROBOND / name).read_text().splitlines(keepends=True)
        (folder / name).write_text("".join(lines[:100]))
    code, said, _ = told(folder, "--format", "robond", "--out", tmp_path / "a.html")
    assert code == 0
    assert all(said.count(f"| {name} ") > 2 for name in WHAT_IT_IS)
    assert (tmp_path / "a.html").read_text().count("<img") == 2 * len(WHAT_IT_IS) + 2
