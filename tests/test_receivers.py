"""The example receivers, as processes of their own on real sockets

They wait for events and measure nothing.
"""

import shutil
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import replace
from pathlib import Path

import pytest

from echogrid.mapping.virtual_sensor import ObstacleView, StopReason
from echogrid.runtime.outputs.binary import datagram

from .runtime.views import CLEAR, STOPPED

FOLDER = Path(__file__).resolve().parents[1] / "examples" / "receivers"
LONG_S = 20.0
PATIENT_MS = 15_000
"""A time-out that does not pass while a test goes on."""
Sender = socket.socket


class Receiver:
    """One at work: what it says, line by line."""

    def __init__(
        self, process: "subprocess.Popen[str]", client: Sender, address: str | tuple[str, int]
    ) -> None:
        self._process = process
        self._client = client
        self._address = address
        self._lines: list[str] = []
        self._changed = threading.Condition()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()
        self._sequence = 0
        self.expect("STOP no valid frame yet")

    def _read(self) -> None:
        assert self._process.stdout is not None
        for text in self._process.stdout:
            with self._changed:
                self._lines.append(text.strip())
                self._changed.notify_all()

    def expect(self, line: str) -> None:
        """Wait until it says this; all that it says before is taken."""
        with self._changed:
            assert self._changed.wait_for(lambda: line in self._lines, LONG_S), (line, self._lines)
            del self._lines[: self._lines.index(line) + 1]

    def said(self) -> list[str]:
        with self._changed:
            return list(self._lines)

    def tell(self, data: bytes) -> None:
        self._client.sendto(data, self._address)

    def view(self, view: ObstacleView = CLEAR, skip: int = 0) -> bytes:
        """The next datagram, stamped now, behind so many that are lost."""
        self._sequence += skip
        data = datagram(replace(view, stamp_ns=time.monotonic_ns()), self._sequence)
        self._sequence += 1
        return data

    def join(self) -> None:
        self._reader.join(LONG_S)


@pytest.fixture(scope="session")
def compiled(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """The receiver in C."""
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("there is no cc here: apt-get install gcc")
    program = tmp_path_factory.mktemp("receiver") / "obstacle_receiver"
    source = FOLDER / "obstacle_receiver.c"
    command = [compiler, "-O2", "-Wall", "-Wextra", "-Werror", "-o", str(program), str(source)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    return [str(program)]


@pytest.fixture(params=["python", "c"])
def program(request: pytest.FixtureRequest) -> list[str]:
    """What runs a receiver."""
    if request.param == "python":
        return [sys.executable, str(FOLDER / "obstacle_receiver.py")]
    made: list[str] = request.getfixturevalue("compiled")
    return made


def command(program: list[str], address: str, timeout_ms: int) -> list[str]:
    option = ["--timeout-ms"] if program[0] == sys.executable else []
    return [*program, address, *option, str(timeout_ms)]


@contextmanager
def receiving(
    program: list[str], folder: Path, kind: str, timeout_ms: int = PATIENT_MS
) -> Iterator[Receiver]:
    """A receiver that is ready."""
    if kind == "unix":
        place: str | tuple[str, int] = str(folder / "obstacles.sock")
        address, client = f"unix:{place}", socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    else:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
            free.bind(("127.0.0.1", 0))
            place = free.getsockname()
        address, client = f"udp:127.0.0.1:{place[1]}", socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    with (
        closing(client),
        subprocess.Popen(command(program, address, timeout_ms), stdout=subprocess.PIPE, text=True) as process,
    ):
        receiver = Receiver(process, client, place)
        try:
            yield receiver
        finally:
            process.kill()
            receiver.join()


@pytest.mark.parametrize("kind", ["unix", "udp"])
def test_it_goes_by_the_limit_and_stops_by_the_reason(program: list[str], tmp_path: Path, kind: str) -> None:
    with receiving(program, tmp_path, kind) as receiver:
        receiver.tell(receiver.view())
        receiver.expect("GO 0.38 m/s")
        for reason in StopReason:
            receiver.tell(receiver.view(replace(STOPPED, reason=reason)))
            receiver.expect(f"STOP {reason.value}")


@pytest.mark.parametrize("kind", ["unix", "udp"])
def test_it_stops_when_nothing_comes_any_more_and_goes_on_when_it_does(
    program: list[str], tmp_path: Path, kind: str
) -> None:
    with receiving(program, tmp_path, kind, timeout_ms=150) as receiver:
        for _ in range(2):
            receiver.tell(receiver.view())
            receiver.expect("GO 0.38 m/s")
            receiver.expect("STOP no valid frame for 150 ms")


def test_it_tells_how_many_were_lost(program: list[str], tmp_path: Path) -> None:
    with receiving(program, tmp_path, "unix") as receiver:
        receiver.tell(receiver.view(skip=5))
        receiver.expect("GO 0.38 m/s")
        receiver.tell(receiver.view(skip=3))
        receiver.expect("LOST 3")
        receiver.tell(receiver.view(STOPPED))
        receiver.expect("STOP silent")


def test_a_sender_that_was_started_anew_is_no_gap(program: list[str], tmp_path: Path) -> None:
    with receiving(program, tmp_path, "unix") as receiver:
        receiver.tell(receiver.view(skip=1000))
        receiver.expect("GO 0.38 m/s")
        receiver.tell(datagram(replace(STOPPED, stamp_ns=time.monotonic_ns()), 0))
        receiver.expect("STOP silent")
        receiver.tell(datagram(replace(CLEAR, stamp_ns=time.monotonic_ns()), 1))
        receiver.expect("GO 0.38 m/s")
        assert receiver.said() == []


def test_what_is_damaged_of_another_version_cut_or_repeated_keeps_nobody_going(
    program: list[str], tmp_path: Path
) -> None:
    with receiving(program, tmp_path, "unix", timeout_ms=300) as receiver:
        whole = receiver.view()
        receiver.tell(whole)
        receiver.expect("GO 0.38 m/s")
        stop = threading.Event()

        def babble() -> None:
            fresh = receiver.view(STOPPED)
            while not stop.wait(0.01):
                for noise in (
                    whole,
                    b"",
                    fresh[:-1],
                    fresh[:4] + b"\2" + fresh[5:],
                    fresh[:70] + b"\7" + fresh[71:],
                ):
                    receiver.tell(noise)

        babbler = threading.Thread(target=babble)
        babbler.start()
        try:
            receiver.expect("STOP no valid frame for 300 ms")
        finally:
            stop.set()
            babbler.join(LONG_S)
        assert "STOP silent" not in receiver.said()


def test_over_a_unix_socket_an_old_frame_is_refused(program: list[str], tmp_path: Path) -> None:
    with receiving(program, tmp_path, "unix", timeout_ms=400) as receiver:
        receiver.tell(datagram(replace(CLEAR, stamp_ns=time.monotonic_ns() - 10**9), 0))
        receiver.tell(receiver.view(STOPPED))
        receiver.expect("STOP silent")
        assert "GO 0.38 m/s" not in receiver.said()


def test_a_wrong_address_is_told(compiled: list[str]) -> None:
    for address in ("tcp:1.2.3.4:5", "udp:robot:7", "unix:" + "x" * 200):
        done = subprocess.run([*compiled, address], capture_output=True, text=True, timeout=20, check=False)
        assert done.returncode == 2
        assert address.split(":", 1)[1].rsplit(":", 1)[0] in done.stderr
