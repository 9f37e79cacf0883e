import os
import select
import stat
from pathlib import Path

import pytest

from echogrid.emulation.control import request
from echogrid.runtime.emulator_process import EmulatorError, _server, emulator

LONG_S = 20.0


def test_it_serves_while_the_context_lasts_and_leaves_nothing(short_dir: Path) -> None:
    with emulator(short_dir, 1):
        process = _server(short_dir / "control.sock")
        assert process is not None
        assert process != os.getpid()
        assert "ring_0" in request(short_dir / "control.sock", {"list": True})["verbs"]
        watched = os.pidfd_open(process)
    assert select.select([watched], [], [], LONG_S)[0]
    os.close(watched)
    assert not short_dir.exists()


def test_another_emulator_in_the_folder_is_not_taken_for_its_own(short_dir: Path) -> None:
    with emulator(short_dir, 1):
        with pytest.raises(EmulatorError, match="another emulator lives here"), emulator(short_dir, 2):
            pass
        assert _server(short_dir / "control.sock") is not None


def test_a_folder_that_is_a_file_is_told(short_dir: Path) -> None:
    short_dir.write_text("")
    with (
        pytest.raises(EmulatorError, match=f"{short_dir}: cannot be used: Not a directory"),
        emulator(short_dir, 1),
    ):
        pass


def test_nobody_serves_where_nobody_listens(short_dir: Path) -> None:
    assert _server(short_dir / "control.sock") is None
    short_dir.mkdir()
    (short_dir / "control.sock").write_text("")
    assert not stat.S_ISSOCK((short_dir / "control.sock").stat().st_mode)
    assert _server(short_dir / "control.sock") is None
