import json
import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from echogrid.runtime.command_line import main
from echogrid.runtime.emulated import DEFAULT_ROBOT

from . import recordings

COMMANDS = ("run", "map", "schedule", "scan", "read", "emulate", "fault", "compare", "evaluate", "trial")
OUTPUTS = {"map.yaml", "map.pgm", "map.png", "map.npz", "trajectory.tum", "report.json"}
LONG_S = 60.0
Told = Callable[..., tuple[int, str, str]]


@pytest.fixture
def told(capsys: pytest.CaptureFixture[str]) -> Told:
    """Exit code, results and messages of a command that is run in this process."""

    def run(*arguments: str | Path) -> tuple[int, str, str]:
        code = main([str(argument) for argument in arguments])
        out, err = capsys.readouterr()
        return code, out, err

    return run


def process(*arguments: str, **options: object) -> "subprocess.CompletedProcess[str]":
    command = [sys.executable, "-m", "echogrid", *arguments]
    return subprocess.run(command, text=True, timeout=LONG_S, check=False, **options)  # type: ignore[call-overload,no-any-return]


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_explains_itself(told: Told, command: str) -> None:
    code, out, err = told(command, "--help")
    assert (code, err) == (0, "")
    assert out.startswith(f"usage: echogrid {command}")


def test_the_help_names_every_command(told: Told) -> None:
    code, out, _ = told("--help")
    assert code == 0
    assert all(command in out for command in COMMANDS)


def test_it_tells_its_version(told: Told) -> None:
    assert told("--version")[:2] == (0, "echogrid 0.1.0\n")


@pytest.mark.parametrize(
    "arguments",
    [
        (),
        ("fly",),
        ("run", "--duration", "soon"),
        ("run", "--seed", "x"),
        ("run", "--goto", "1"),
        ("run", "--goto", "1", "inf"),
        ("run", "--wander", "--guard", "udp:7655"),
        ("map", "log"),
        ("map", "log", "--out", "o", "--resolution", "-1"),
        ("map", "log", "--out", "o", "--theory", "guess"),
        ("fault",),
        ("fault", "ring_0"),
        ("fault", "ring_0", "off", "--for", "0s"),
    ],
)
def test_misuse_is_2_with_words_on_stderr_only(told: Told, arguments: tuple[str, ...]) -> None:
    code, out, err = told(*arguments)
    assert (code, out) == (2, "")
    assert "echogrid" in err


@pytest.mark.parametrize(
    ("arguments", "told_first"),
    [
        (("run", "--map", "map.yaml"), "--map: "),
        (("run", "--wander", "--map", "map.yaml"), "--map: "),
        (("run", "--goto", "1", "0", "--at", "0", "0", "0"), "--at: "),
        (("run", "--goto", "1", "0", "--map", "gone.yaml"), "gone.yaml: no such file"),
    ],
)
def test_a_map_that_nobody_can_drive_by_is_told_in_one_line(
    told: Told, arguments: tuple[str, ...], told_first: str
) -> None:
    code, out, err = told(*arguments)
    assert (code, out) == (2, "")
    assert err.startswith(told_first)
    assert err.count("\n") == 1


# map


def test_map_writes_all_its_files_and_ends_with_0(told: Told, tmp_path: Path) -> None:
    folder = recordings.write(tmp_path / "log")
    code, out, err = told("map", folder, "--out", tmp_path / "out")
    assert (code, err) == (0, "")
    assert out.endswith(f"the map is in {tmp_path}/out\n")
    assert {path.name for path in (tmp_path / "out").iterdir()} == OUTPUTS


@pytest.mark.parametrize(("strict", "code"), [((), 0), (("--strict",), 1)])
def test_row_faults_are_told_one_line_a_reason_and_only_strict_minds(
    told: Told, tmp_path: Path, strict: tuple[str, ...], code: int
) -> None:
    faulty = [
        "x,front,1",
        "1e999999999,front,1",
        "nan,front,1",
        "1,rear,1",
        "1,front",
        "1,front,-1",
        "99,front,1",
    ]
    poses = [*recordings.pose_rows(), "0.1,0,0,0"]
    folder = recordings.write(
        tmp_path / "log", ranges=[*recordings.range_rows(), *faulty, *faulty], poses=poses
    )
    done, _, err = told("map", folder, "--out", tmp_path / "out", *strict)
    assert done == code
    first = len(recordings.range_rows()) + 2
    assert err.splitlines() == [
        f"{folder}/poses.csv:{len(poses) + 1}: pose not monotonic: 1 row skipped from here on",
        f"{folder}/ranges.csv:{first}: unparsable: 4 rows skipped from here on",
        f"{folder}/ranges.csv:{first + 1}: stamp out of range: 2 rows skipped from here on",
        f"{folder}/ranges.csv:{first + 2}: non-finite stamp: 2 rows skipped from here on",
        f"{folder}/ranges.csv:{first + 3}: unknown sensor: 2 rows skipped from here on",
        f"{folder}/ranges.csv:{first + 5}: negative range: 2 rows skipped from here on",
        f"{folder}/ranges.csv:{first + 6}: range outside the pose span: 2 rows skipped from here on",
    ]
    report = json.loads((tmp_path / "out/report.json").read_text())
    assert report["rows_skipped"]["unparsable"] == 4
    right = recordings.write(tmp_path / "right")
    told("map", right, "--out", tmp_path / "as it should be")
    for name in ("map.npz", "trajectory.tum"):
        assert (tmp_path / "out" / name).read_bytes() == (tmp_path / "as it should be" / name).read_bytes()


def test_a_faultless_recording_satisfies_strict(told: Told, tmp_path: Path) -> None:
    assert told("map", recordings.write(tmp_path / "log"), "--out", tmp_path / "out", "--strict")[0] == 0


def spoil(folder: Path, how: str) -> Path:
    recordings.write(folder)
    changes: dict[str, Callable[[], object]] = {
        "no folder": lambda: [path.unlink() for path in folder.iterdir()] and folder.rmdir(),
        "no robot.toml": (folder / "robot.toml").unlink,
        "no ranges": (folder / "ranges.csv").unlink,
        "no poses": (folder / "poses.csv").unlink,
        "bad robot.toml": lambda: (folder / "robot.toml").write_text("[robot"),
        "no sensor": lambda: (folder / "robot.toml").write_text("[robot]"),
        "bad header": lambda: (folder / "ranges.csv").write_text("a,b,c\n"),
        "empty poses": lambda: (folder / "poses.csv").write_text(""),
        "no usable pose": lambda: (folder / "poses.csv").write_text("stamp_s,x_m,y_m,yaw_rad\nx,0,0,0\n"),
        "binary poses": lambda: (folder / "poses.csv").write_bytes(bytes(range(256)) * 100),
        "monstrous extent": lambda: (folder / "poses.csv").write_text(
            "stamp_s,x_m,y_m,yaw_rad\n0,0,0,0\n1,1e8,1e8,0\n"
        ),
    }
    changes[how]()
    return folder


@pytest.mark.parametrize(
    "how",
    [
        "no folder",
        "no robot.toml",
        "no ranges",
        "no poses",
        "bad robot.toml",
        "no sensor",
        "bad header",
        "empty poses",
        "no usable pose",
        "binary poses",
        "monstrous extent",
    ],
)
def test_what_is_no_recording_is_2_and_nothing_is_written(told: Told, tmp_path: Path, how: str) -> None:
    code, out, err = told("map", spoil(tmp_path / "log", how), "--out", tmp_path / "out")
    assert (code, out) == (2, "")
    assert len(err) > 20
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("resolution", ["0.001", "100", "1e300"])
def test_an_impossible_resolution_is_2_and_nothing_is_written(
    told: Told, tmp_path: Path, resolution: str
) -> None:
    folder = recordings.write(tmp_path / "log")
    code, _, err = told("map", folder, "--out", tmp_path / "out", "--resolution", resolution)
    assert (code, err) == (2, "echogrid map: `resolution_m` must lie in 0.005...10\n")
    assert not (tmp_path / "out").exists()


def test_what_is_told_on_the_command_line_goes_before_the_configuration(told: Told, tmp_path: Path) -> None:
    folder = recordings.write(tmp_path / "log")
    told(
        "map",
        folder,
        "--out",
        tmp_path / "coarse",
        "--resolution",
        "0.2",
        "--theory",
        "bayes",
        "--no-echo",
        "ignore",
    )
    assert "resolution: 0.2\n" in (tmp_path / "coarse/map.yaml").read_text()
    report = json.loads((tmp_path / "coarse/report.json").read_text())
    assert report["dropped"]["no echo"] == report["outcomes"]["no echo"]


@pytest.mark.parametrize("place", ["file", "file/below"])
def test_a_place_where_nothing_can_be_written_is_1_in_words(told: Told, tmp_path: Path, place: str) -> None:
    (tmp_path / "file").write_text("")
    code, _, err = told("map", recordings.write(tmp_path / "log"), "--out", tmp_path / place)
    assert code == 1
    assert err.startswith(f"{tmp_path}/file")


# run


@pytest.mark.parametrize("option", ["--out", "--log"])
def test_a_run_that_could_not_write_does_not_begin(told: Told, tmp_path: Path, option: str) -> None:
    (tmp_path / "file").write_text("")
    places = {"--out": tmp_path / "out", "--log": tmp_path / "log"} | {option: tmp_path / "file"}
    arguments = [each for pair in places.items() for each in pair]
    code, out, err = told("run", "--simulate", "--duration", "1h", *arguments)
    assert (code, out) == (1, "")
    assert err.startswith(f"{tmp_path}/file: ")


def test_a_robot_with_mistakes_is_2_with_every_one_of_them(told: Told, tmp_path: Path) -> None:
    path = tmp_path / "robot.toml"
    path.write_text(
        DEFAULT_ROBOT.read_text().replace("node = 0", "nod = 0").replace("width_m = 40.0\nheight_m", "#")
    )
    for command in (("run", path), ("run", "--simulate", path, "--duration", "1s")):
        code, out, err = told(*command)
        assert (code, out) == (2, "")
        assert [line.split(": ", 1)[1] for line in err.splitlines()] == [
            "map: a run needs `width_m` and `height_m`",
            "wheel[0]: unknown key `nod` (did you mean `node`?)",
        ]


def test_missing_ports_are_1_with_device_port_and_mend(told: Told, tmp_path: Path) -> None:
    path = tmp_path / "robot.toml"
    path.write_text(DEFAULT_ROBOT.read_text())
    code, out, err = told("run", path)
    assert (code, out) == (1, "")
    assert (
        f"front_left: {tmp_path}/front_left_line: cannot open this serial port: it is not there (is it" in err
    )
    assert "ring_0, ring_45" in err


def test_a_run_too_short_to_read_anything_is_1_and_says_what_was_not_read(told: Told, tmp_path: Path) -> None:
    code, out, err = told("run", "--simulate", "--duration", "50ms", "--out", tmp_path)
    assert code == 1
    assert out.startswith(f"map: {tmp_path}/map.yaml")
    assert "never read: ring_0, ring_45" in err
    assert {path.name for path in tmp_path.iterdir()} == OUTPUTS


# emulate and fault


def test_a_fault_without_an_emulator_is_1_in_words(told: Told, tmp_path: Path) -> None:
    code, _, err = told("fault", "list", "--dir", tmp_path)
    assert code == 1
    assert "start one with: echogrid emulate" in err


def test_faults_are_told_to_the_emulator_and_listed(told: Told, short_dir: Path) -> None:
    from echogrid.runtime.emulator_process import emulator

    with emulator(short_dir, 1):
        assert told("fault", "ring_0", "off", "--for", "60s", "--dir", short_dir) == (0, "", "")
        assert told("fault", "ring_0", "stuck", "--dir", short_dir) == (0, "", "")
        code, out, _ = told("fault", "list", "--dir", short_dir)
        lines = {line.split()[0]: line for line in out.splitlines()}
        assert code == 0
        assert re.search(r"  now: off \(for [56]\d\.\d s more\), stuck$", lines["ring_0"])
        assert "unplug" in lines["wheel_bus"]
        assert told("fault", "ring_0", "clear", "--dir", short_dir)[0] == 0
        assert "now:" not in told("fault", "list", "--dir", short_dir)[1]
        code, _, err = told("fault", "ring_1", "off", "--dir", short_dir)
        assert (code, "did you mean 'ring_" in err) == (1, True)


def test_a_robot_that_cannot_be_emulated_is_2(told: Told, tmp_path: Path, short_dir: Path) -> None:
    path = tmp_path / "robot.toml"
    path.write_text(DEFAULT_ROBOT.read_text().replace("address = 0x70", "address = [1]"))
    code, _, err = told("emulate", path, "--dir", short_dir)
    assert code == 2
    assert "sensor[0].address: expected a whole number, not [1]" in err
    assert not short_dir.exists()


def test_a_robot_toml_of_the_user_s_own_is_never_overwritten(told: Told, short_dir: Path) -> None:
    short_dir.mkdir()
    own = short_dir / "robot.toml"
    own.write_text("# mine\n")
    code, _, err = told("emulate", "--dir", short_dir)
    assert (code, own.read_text()) == (2, "# mine\n")
    assert err == f"{own}: is in the way (move it, or choose another --dir)\n"


# processes


def test_help_needs_none_of_the_slow_libraries() -> None:
    program = (
        "import sys\nfrom echogrid.runtime.command_line import main\nassert main(['--help']) == 0\n"
        "slow = {'numpy', 'can', 'serial', 'smbus2', 'cattrs', 'asyncio'}\n"
        "print(sorted(slow & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.endswith("\n[]\n")


@pytest.mark.parametrize("arguments", [("--help",), ("run", "--help"), ("fault", "list")])
def test_a_reader_that_has_gone_is_no_matter_for_words(arguments: tuple[str, ...], tmp_path: Path) -> None:
    reader, writer = os.pipe()
    os.close(reader)
    where = ("--dir", str(tmp_path)) if arguments[0] == "fault" else ()
    done = process(*arguments, *where, stdout=writer, stderr=subprocess.PIPE)
    os.close(writer)
    assert done.returncode in (0, 1)
    assert "roken" not in done.stderr
    assert "Traceback" not in done.stderr


def test_a_run_outlives_the_readers_of_what_it_says(tmp_path: Path) -> None:
    reader, writer = os.pipe()
    os.close(reader)
    done = process(
        *("run", "--simulate", "--duration", "3s", "--out", str(tmp_path)), stdout=writer, stderr=writer
    )
    os.close(writer)
    assert done.returncode == 1
    assert {path.name for path in tmp_path.iterdir()} == OUTPUTS


def test_a_mistake_in_a_process_is_2_without_a_traceback(tmp_path: Path) -> None:
    done = process("map", str(tmp_path), "--out", str(tmp_path / "out"), capture_output=True)
    assert (done.returncode, done.stdout) == (2, "")
    assert "Traceback" not in done.stderr
    assert len(done.stderr.splitlines()) == 3


def test_a_map_that_cannot_be_written_costs_neither_the_account_nor_a_traceback(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "out" / "map.npz").mkdir(parents=True)
    code = main(["run", "--simulate", "--duration", "2s", "--out", str(tmp_path / "out")])
    told = capsys.readouterr().err
    assert code == 1
    assert "map.npz: " in told
    assert "the map is not complete" in told
    assert "range readings: " in told


@pytest.mark.parametrize("command", ["run", "map"])
def test_a_file_in_the_place_of_a_folder_is_told_so(told: Told, tmp_path: Path, command: str) -> None:
    (tmp_path / "file").write_text("")
    what = ("run", "--simulate") if command == "run" else ("map", recordings.write(tmp_path / "log"))
    code, _, err = told(*what, "--out", tmp_path / "file")
    assert (code, err) == (1, f"{tmp_path}/file: is no folder\n")


@pytest.mark.parametrize("closed", [">&-", "2>&-", "<&- >&- 2>&-"])
@pytest.mark.parametrize("arguments", ["--help", "schedule", "fault list --dir /nowhere"])
def test_closed_streams_are_no_matter(arguments: str, closed: str) -> None:
    command = f"exec {sys.executable} -m echogrid {arguments} {closed}"
    done = subprocess.run(command, shell=True, text=True, capture_output=True, check=False)
    assert done.returncode == (1 if "fault" in arguments else 0)
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize("loading", ["echogrid.runtime.command_line", "argparse", "echogrid.runtime.config"])
def test_an_interrupt_while_it_is_being_loaded_ends_it_quietly(loading: str) -> None:
    program = (
        "import runpy, sys\n"
        "class Interrupt:\n"
        "    def find_spec(self, name, *_):\n"
        f"        if name == {loading!r}: raise KeyboardInterrupt\n"
        "sys.modules.pop('argparse', None)\n"
        "sys.meta_path.insert(0, Interrupt())\n"
        "sys.argv = ['echogrid', 'schedule']\n"
        "runpy.run_module('echogrid', run_name='__main__')\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "")
