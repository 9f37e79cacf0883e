"""What the service manager hears, on a real socket of its kind."""

import socket
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from echogrid.runtime.command_line import main
from echogrid.runtime.notify import ServiceManager


@contextmanager
def manager(path: Path) -> Iterator[socket.socket]:
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as ear:
        ear.bind(str(path))
        ear.settimeout(5.0)
        yield ear


def heard(ear: socket.socket) -> list[str]:
    """All that has been told so far."""
    ear.setblocking(False)
    messages = []
    try:
        while True:
            messages.append(ear.recv(4096).decode())
    except BlockingIOError:
        return messages


def test_each_word_is_one_message(tmp_path: Path) -> None:
    with manager(tmp_path / "n") as ear:
        told = ServiceManager(str(tmp_path / "n"))
        told.ready()
        told.alive("50 Hz\n all well")
        told.stopping()
        assert heard(ear) == ["READY=1", "WATCHDOG=1\nSTATUS=50 Hz all well", "STOPPING=1"]


def test_an_abstract_address_is_understood() -> None:
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as ear:
        ear.bind("\0echogrid-test-notify")
        ServiceManager("@echogrid-test-notify").ready()
        assert heard(ear) == ["READY=1"]


@pytest.mark.parametrize("address", [None, "", "/nowhere/at/all"])
def test_where_nobody_listens_nothing_fails(address: str | None) -> None:
    told = ServiceManager(address)
    told.ready()
    told.alive("well")
    told.stopping()


def test_a_run_is_ready_then_alive_every_second_then_stopping(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with manager(tmp_path / "n") as ear:
        monkeypatch.setenv("NOTIFY_SOCKET", str(tmp_path / "n"))
        code = main(["run", "--simulate", "--duration", "3.5s", "--out", str(tmp_path / "out")])
        messages = heard(ear)
    assert code == 0
    assert messages[0] == "READY=1"
    assert messages[-1] == "STOPPING=1"
    alive = [message for message in messages if message.startswith("WATCHDOG=1\nSTATUS=")]
    assert len(alive) == len(messages) - 2 == 3
    assert all("Hz" in message and " ok" in message for message in alive)
    assert "readings/s" not in capsys.readouterr().err
