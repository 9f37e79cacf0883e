"""What is no log is told in one line."""

from pathlib import Path

import pytest

from echogrid.runtime.errors import UsageError
from echogrid.runtime.recording import read_simple


def test_a_folder_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(UsageError) as refused:
        read_simple(tmp_path / "nowhere")
    assert list(refused.value.problems) == [f"{tmp_path}/nowhere: no such folder"]


def test_a_recording_of_another_format_is_told_with_its_option(tmp_path: Path) -> None:
    (tmp_path / "measurement.txt").touch()
    with pytest.raises(UsageError) as refused:
        read_simple(tmp_path)
    (problem,) = refused.value.problems
    assert problem.endswith("try --format robond")
