import json
from math import isfinite
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from echogrid.mapping.empirical_model import Bins, Empirical, EmpiricalOfEach
from echogrid.mapping.subjective_model import Subjective
from echogrid.runtime import assembly, recording, sonar_model_file
from echogrid.runtime.command_line import main
from echogrid.runtime.emulated import DEFAULT_ROBOT
from echogrid.runtime.errors import UsageError

from . import recordings

BINS = Bins((-4.0, -0.1, 0.2), (0.0, 0.1, 0.1 + 1.0 / 3.0), (0.0, 1.0, 3.0))
ratios = st.floats(-9.0, 9.0)


def model(of_echo: float = 0.7, of_silence: float = -0.1) -> Empirical:
    return Empirical(BINS, np.full(BINS.echo_shape, of_echo), np.full(BINS.silence_shape, of_silence))


def text(of_echo: float = 0.7) -> str:
    return sonar_model_file.text([sonar_model_file.table(["front"], 99, 0.2, model(of_echo))])


def robot(folder: Path, told: str | None = None, lines: str = 'model_file = "sonar.json"') -> Path:
    """A recording with a model beside its robot.toml."""
    robot = recordings.ROBOT.replace("[map]\n", f'[map]\nmodel = "empirical"\n{lines}\n')
    recordings.write(folder, robot=robot)
    (folder / "sonar.json").write_text(text() if told is None else told)
    return folder


@given(st.lists(ratios, min_size=8, max_size=8), st.lists(ratios, min_size=4, max_size=4))
def test_what_was_written_is_read_to_the_same_bits(tmp_path_factory, echo, silence) -> None:
    written = Empirical(BINS, np.array(echo).reshape(2, 2, 2), np.array(silence).reshape(2, 2))
    path = tmp_path_factory.mktemp("models") / "sonar.json"
    path.write_text(sonar_model_file.text([sonar_model_file.table(["a", "b"], 7, 0.1, written)]))
    read = sonar_model_file.read(path)
    assert set(read) == {"a", "b"}
    for each in read.values():
        assert each.bins == written.bins
        assert each.of_echo.tobytes() == written.of_echo.tobytes()
        assert each.of_silence.tobytes() == written.of_silence.tobytes()


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        (("sonar model", "recipe"), "echogrid: expected one of sonar model"),
        (('"version": 1', '"version": 2'), "version 2 of the file; this program reads version 1"),
        (('"sensors"', '"sensor"'), "unknown key `sensor` (did you mean `sensors`?)"),
        (("[-4.0, ", "[-0.05, "), "bins have at least two borders"),
        (("[-4.0, ", "["), "the tables' shapes are"),
        (("0.7", '"x"'), "expected a number, not 'x'"),
        (("0.7", "NaN"), "expected a number, not nan"),
        (("{", ""), "not JSON"),
    ],
)
def test_what_is_wrong_with_a_file_is_told_with_place_and_mend(
    tmp_path: Path, change: tuple[str, str], problem: str
) -> None:
    path = tmp_path / "sonar.json"
    path.write_text(text().replace(*change))
    with pytest.raises(UsageError) as raised:
        sonar_model_file.read(path)
    assert str(path) in str(raised.value)
    assert problem in str(raised.value)
    assert "`echogrid calibrate sensor LOG --write robot.toml`" in str(raised.value)


@given(st.binary(max_size=40), st.integers(0, 10_000))
def test_no_damage_to_a_file_does_more_than_be_told(tmp_path_factory, junk: bytes, place: int) -> None:
    path = tmp_path_factory.mktemp("models") / "sonar.json"
    whole = text().encode()
    at = place % len(whole)
    path.write_bytes(whole[:at] + junk + whole[at + len(junk) :])
    try:
        models = sonar_model_file.read(path)
    except UsageError:
        return
    assert all(isfinite(each.of_echo.sum()) for each in models.values())


def test_a_robot_s_sensors_have_the_file_s_models_and_others_the_book_s(tmp_path: Path) -> None:
    found = assembly.sonar_model(recording.read_simple(robot(tmp_path)).config)
    assert isinstance(found, EmpiricalOfEach)
    assert list(found.own) == ["front"]
    assert found.otherwise == Subjective()


@pytest.mark.parametrize("theory", ["bayes", "dempster-shafer"])
def test_a_map_is_made_with_the_file_s_model(tmp_path: Path, theory: str) -> None:
    maps = []
    for number, ratio in enumerate((0.2, 1.2)):
        log = robot(tmp_path / str(number), text(ratio))
        assert main(["map", str(log), "--out", str(log / "out"), "--theory", theory]) == 0
        with np.load(log / "out/map.npz") as arrays:
            maps.append(arrays["occupancy"])
    assert maps[0].shape == maps[1].shape
    assert maps[0].mean() < maps[1].mean()


@pytest.mark.parametrize(
    ("lines", "problem"),
    [
        ("", '`model_file` is needed for model = "empirical"'),
        ('model_file = "gone.json"', "gone.json: No such file or directory"),
        ('model_file = "../sonar.json"', "is the name of a file beside robot.toml, not a path"),
    ],
)
def test_a_model_that_is_not_there_is_told_with_the_line(tmp_path: Path, lines: str, problem: str) -> None:
    with pytest.raises(UsageError) as raised:
        recording.read_simple(robot(tmp_path, lines=lines))
    assert f"{tmp_path}/robot.toml:" in str(raised.value)
    assert problem in str(raised.value)


def test_a_run_takes_the_model_into_its_log_so_that_the_log_gives_the_run_s_map(tmp_path: Path) -> None:
    told = '[map]\nmodel = "empirical"\nmodel_file = "sonar.json"\ntheory = "bayes"\n'
    path = tmp_path / "robot.toml"
    path.write_text(DEFAULT_ROBOT.read_text().replace("[map]\n", told))
    (tmp_path / "sonar.json").write_text(text().replace("front", "front_left"))
    run = ["run", str(path), "--simulate", "--duration", "5s", "--out", str(tmp_path / "live")]
    assert main([*run, "--log", str(tmp_path / "log")]) == 0
    assert main(["map", str(tmp_path / "log"), "--out", str(tmp_path / "again")]) == 0
    assert (tmp_path / "log/sonar.json").read_bytes() == (tmp_path / "sonar.json").read_bytes()
    assert (tmp_path / "live/map.npz").read_bytes() == (tmp_path / "again/map.npz").read_bytes()


def test_the_file_is_plain_json_for_people_to_read() -> None:
    told = json.loads(text())
    assert told["echogrid"] == "sonar model"
    assert told["models"][0]["sensors"] == ["front"]
    assert len(text().splitlines()) == 10
