"""The import package is laid out by links: they must be there, and a wheel must hold what they lead to."""

import shutil
import subprocess
import sys
from pathlib import Path
from zipfile import ZipFile

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = ("drivers", "mapping", "runtime", "emulation")
LITTER = shutil.ignore_patterns("__pycache__", "*.egg-info")


@pytest.mark.parametrize("package", PACKAGES)
def test_the_links_are_relative_and_lead_to_the_top_level_folders(package: str) -> None:
    link = ROOT / "src/echogrid" / package
    assert link.readlink() == Path("../..") / package
    assert link.resolve() == ROOT / package
    assert (link / "__init__.py").is_file()


@pytest.mark.parametrize("package", PACKAGES)
def test_every_folder_with_modules_is_a_package(package: str) -> None:
    folders = {path.parent for path in (ROOT / package).rglob("*.py")}
    assert [folder for folder in folders if not (folder / "__init__.py").is_file()] == []


@pytest.fixture(scope="module")
def wheel_names(tmp_path_factory: pytest.TempPathFactory) -> set[str]:
    """The names of all files in a wheel that was built from a copy of the tree."""
    copy = tmp_path_factory.mktemp("tree")
    for name in ("src", *PACKAGES):
        shutil.copytree(ROOT / name, copy / name, symlinks=True, ignore=LITTER)
    for name in ("pyproject.toml", "LICENSE"):
        shutil.copy(ROOT / name, copy)
    (copy / "README.md").write_text("# echogrid\n")
    command = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(copy / "dist")]
    done = subprocess.run(command, cwd=copy, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    (wheel,) = (copy / "dist").glob("*.whl")
    with ZipFile(wheel) as archive:
        return set(archive.namelist())


@pytest.mark.parametrize("package", PACKAGES)
def test_the_wheel_holds_every_module_and_settings_file(package: str, wheel_names: set[str]) -> None:
    expected = {
        f"echogrid/{path.relative_to(ROOT)}"
        for pattern in ("*.py", "*.toml")
        for path in (ROOT / package).rglob(pattern)
    }
    assert f"echogrid/{package}/__init__.py" in expected
    assert expected - wheel_names == set()


def test_the_wheel_says_that_it_is_typed(wheel_names: set[str]) -> None:
    assert "echogrid/py.typed" in wheel_names


def test_the_wheel_holds_the_emulated_robot_s_settings(wheel_names: set[str]) -> None:
    assert "echogrid/runtime/emulated_robot.toml" in wheel_names


def test_the_wheel_brings_the_command_and_no_other_top_level_package(wheel_names: set[str]) -> None:
    tops = {name.split("/")[0] for name in wheel_names}
    assert {top for top in tops if not top.endswith(".dist-info")} == {"echogrid"}
    assert any(name.endswith(".dist-info/entry_points.txt") for name in wheel_names)
