"""Folders, and one simulated run that many tests look at."""

import shutil
import signal
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from echogrid.runtime.command_line import main


@pytest.fixture(autouse=True)
def _own_signals() -> Iterator[None]:
    """A run's handlers of signals are its own."""
    numbers = signal.SIGINT, signal.SIGTERM, signal.SIGHUP
    handlers = [signal.getsignal(number) for number in numbers]
    yield
    for number, handler in zip(numbers, handlers, strict=True):
        signal.signal(number, handler)


@pytest.fixture
def short_dir() -> Iterator[Path]:
    """A folder whose path leaves room for the names of sockets."""
    folder = Path(tempfile.mkdtemp(prefix="eg", dir="/tmp"))
    yield folder / "robot"
    shutil.rmtree(folder)


@pytest.fixture(scope="session")
def simulated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Eight simulated seconds of the emulated robot: its outputs in `out`, its log in `log`."""
    folder = tmp_path_factory.mktemp("simulated")
    assert simulate(folder, "3") == 0
    return folder


def simulate(folder: Path, seed: str) -> int:
    places = ["--out", str(folder / "out"), "--log", str(folder / "log")]
    return main(["run", "--simulate", "--duration", "8s", "--seed", seed, *places])
