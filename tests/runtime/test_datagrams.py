"""On real sockets. Nothing waits: what does not come at once was not sent."""

import socket
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
from pytest_mock import MockerFixture

from echogrid.mapping.virtual_sensor import ObstacleView
from echogrid.runtime.outputs.binary import datagram
from echogrid.runtime.outputs.datagrams import DatagramOutput, Format
from echogrid.runtime.outputs.json_line import line
from echogrid.runtime.outputs.pace import Pace

from .told_view import told
from .views import CLEAR, STOPPED, at

MS = 1_000_000


@pytest.fixture
def path(tmp_path: Path) -> str:
    return str(tmp_path / "out.sock")


@pytest.fixture
def receiver(path: str) -> Iterator[socket.socket]:
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as bound:
        bound.bind(path)
        bound.setblocking(False)
        yield bound


def output(address: str | tuple[str, int], form: Format = datagram) -> DatagramOutput:
    return DatagramOutput("here", address, form, Pace(100.0))


def ticks(count: int) -> Iterator[ObstacleView]:
    return (at(CLEAR.stamp_ns + k * 20 * MS) for k in range(count))


@pytest.mark.parametrize("form", [datagram, line])
def test_over_a_unix_socket_the_view_comes_as_it_was_formed(
    path: str, receiver: socket.socket, form: Format
) -> None:
    with closing(output(path, form)) as out:
        for view in (CLEAR, STOPPED):
            out.put(view)
    assert [receiver.recv(65536) for _ in range(2)] == [form(CLEAR, 0), form(STOPPED, 1)]
    assert (out.sent, out.dropped) == (2, {})


@pytest.mark.parametrize(("family", "host"), [(socket.AF_INET, "127.0.0.1"), (socket.AF_INET6, "::1")])
def test_over_udp_too(family: socket.AddressFamily, host: str) -> None:
    with socket.socket(family, socket.SOCK_DGRAM) as bound:
        try:
            bound.bind((host, 0))
        except OSError:
            pytest.skip(f"this machine has no {host}")
        bound.settimeout(5.0)
        with closing(output(bound.getsockname()[:2])) as out:
            out.put(CLEAR)
        assert bound.recv(65536) == datagram(CLEAR, 0)


def test_a_receiver_that_is_not_there_is_counted_and_one_that_comes_is_served(path: str) -> None:
    with closing(output(path)) as out:
        for view in ticks(3):
            out.put(view)
        assert (out.sent, out.dropped) == (0, {"no receiver": 3})
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as bound:
            bound.bind(path)
            bound.setblocking(False)
            out.put(at(CLEAR.stamp_ns + 1000 * MS))
            assert told(bound.recv(65536)).sequence == 3
        out.put(at(CLEAR.stamp_ns + 2000 * MS))
    assert (out.sent, out.dropped) == (1, {"no receiver": 4})


def test_a_udp_port_where_nobody_listens_is_counted_too() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as bound:
        bound.bind(("127.0.0.1", 0))
        address = bound.getsockname()
    with closing(output(address)) as out:
        for view in ticks(20):
            out.put(view)
    assert out.sent + out.dropped["no receiver"] == 20
    assert out.dropped["no receiver"] >= 5


def test_a_receiver_that_does_not_read_slows_nobody_and_sees_the_gap(
    path: str, receiver: socket.socket
) -> None:
    with closing(output(path)) as out:
        for view in ticks(2000):
            out.put(view)
        assert out.sent + out.dropped["receiver too slow"] == 2000
        assert 0 < out.sent < 2000
        first = [told(receiver.recv(65536)).sequence for _ in range(out.sent)]
        out.put(at(CLEAR.stamp_ns + 100_000 * MS))
        assert first == list(range(len(first)))
        assert told(receiver.recv(65536)).sequence == 2000


def test_what_is_no_socket_is_counted(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with closing(output(str(tmp_path / "file"))) as out:
        out.put(CLEAR)
    assert out.dropped == {"no receiver": 1}


def test_an_address_without_a_way_there_is_counted(mocker: MockerFixture) -> None:
    mocker.patch("socket.socket.connect", side_effect=OSError(101, "Network is unreachable"))
    with closing(output(("203.0.113.1", 9))) as out:
        for view in ticks(2):
            out.put(view)
    assert out.dropped == {"unreachable": 2}
    mocker.stopall()


def test_a_trouble_without_a_name_of_ours_is_counted_by_the_system_s(
    mocker: MockerFixture,
) -> None:
    mocker.patch("socket.socket", side_effect=OSError(24, "Too many open files"))
    with closing(output("/nowhere")) as out:
        out.put(CLEAR)
    assert out.dropped == {"EMFILE": 1}


def test_closing_twice_is_once(path: str, receiver: socket.socket) -> None:
    out = output(path)
    out.put(CLEAR)
    out.close()
    out.close()
    assert out.sent == 1
