import json
import os
import socket
import struct
import tty
from collections.abc import Iterator
from math import isfinite
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.twist import Twist
from echogrid.runtime.joystick_wishes import JoystickLayout, JoystickWishes
from echogrid.runtime.socket_wishes import SocketWishes, read_wish, udp_socket, unix_socket
from echogrid.runtime.wishes import FRESH_NS, STANDSTILL

BUTTON, AXIS, INITIAL = 1, 2, 0x80
SECOND_NS = 1_000_000_000


class Sender:
    """Somebody who wants the robot to move."""

    def __init__(self, heard: socket.socket) -> None:
        self.wishes = SocketWishes(heard)
        self._socket = socket.socket(heard.family, socket.SOCK_DGRAM)
        self._socket.connect(heard.getsockname())

    def send(self, data: bytes) -> None:
        self._socket.send(data)

    def want(self, speed: float, turn_rate: float) -> None:
        self.send(json.dumps({"speed": speed, "turn_rate": turn_rate}).encode())

    def close(self) -> None:
        self._socket.close()
        self.wishes.close()


@pytest.fixture(params=["unix", "udp"])
def sender(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Sender]:
    sender = Sender(unix_socket(tmp_path / "wishes") if request.param == "unix" else udp_socket(0))
    yield sender
    sender.close()


def test_nobody_wants_anything_at_first(sender: Sender) -> None:
    assert sender.wishes.poll(0) == STANDSTILL


def test_the_newest_wish_holds_for_300_ms(sender: Sender) -> None:
    sender.want(0.1, 0.0)
    sender.want(0.3, -0.5)
    assert FRESH_NS == 300_000_000
    assert sender.wishes.poll(SECOND_NS) == Twist(0.3, -0.5)
    assert sender.wishes.poll(SECOND_NS + FRESH_NS) == Twist(0.3, -0.5)
    assert sender.wishes.poll(SECOND_NS + FRESH_NS + 1) == STANDSTILL


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (b"", "no JSON"),
        (b"\xff\x00", "no JSON"),
        (b"[" * 400, "no JSON"),
        (b"[0.1, 0.2]", "not an object with speed and turn_rate"),
        (b'{"speed": 1}', "not an object with speed and turn_rate"),
        (b'{"speed": 1, "turn_rate": 0, "more": 1}', "not an object with speed and turn_rate"),
        (b'{"speed": NaN, "turn_rate": 0}', "not two finite numbers"),
        (b'{"speed": 1e999, "turn_rate": 0}', "not two finite numbers"),
        (b'{"speed": 1' + b"0" * 400 + b', "turn_rate": 0}', "not two finite numbers"),
        (b'{"speed": "1", "turn_rate": 0}', "not two finite numbers"),
        (b'{"speed": true, "turn_rate": 0}', "not two finite numbers"),
        (b'{"speed": 0, "turn_rate": -101.0}', "more than 100 m/s or rad/s"),
        (b'{"speed": 1.7e308, "turn_rate": 1.7e308}', "more than 100 m/s or rad/s"),
        (b" " * 513, "too long"),
    ],
)
def test_what_is_no_wish_is_counted_by_its_reason_and_the_last_one_holds(
    sender: Sender, data: bytes, reason: str
) -> None:
    sender.want(0.2, 0.0)
    sender.send(data)
    assert sender.wishes.poll(SECOND_NS) == Twist(0.2, 0.0)
    assert sender.wishes.refused == {reason: 1}


NUMBERS = st.integers() | st.integers(10**300, 10**400) | st.floats()
"""As JSON has them: NaN and the infinities, too, and integers of any length."""


@given(
    st.binary(max_size=600)
    | st.builds(lambda v, w: json.dumps({"speed": v, "turn_rate": w}).encode(), NUMBERS, NUMBERS)
)
def test_whatever_comes_is_a_finite_twist_or_refused(data: bytes) -> None:
    try:
        twist = read_wish(data)
    except ValueError:
        return
    for each in (twist.speed, twist.turn_rate):
        assert isfinite(each)
        assert each == 0.0 or 1e-6 <= abs(each) <= 100.0


def test_a_flood_neither_keeps_the_loop_nor_moves_the_robot() -> None:
    sender = Sender(udp_socket(0))
    for _ in range(100):
        sender.want(0.1, 0.0)
    sender.want(0.4, 0.0)
    assert sender.wishes.poll(SECOND_NS) == STANDSTILL
    assert sender.wishes.refused == {"flooded": 1}
    assert sender.wishes.poll(SECOND_NS) == Twist(0.4, 0.0)
    sender.close()


def test_a_socket_left_by_an_earlier_run_is_replaced(tmp_path: Path) -> None:
    unix_socket(tmp_path / "wishes").close()
    unix_socket(tmp_path / "wishes").close()


def test_a_socket_that_is_heard_is_not_taken_from_its_owner(tmp_path: Path) -> None:
    owner = SocketWishes(unix_socket(tmp_path / "wishes"))
    with pytest.raises(OSError, match="in use"):
        unix_socket(tmp_path / "wishes")
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as sender:
        sender.sendto(b'{"speed": 0.1, "turn_rate": 0.0}', str(tmp_path / "wishes"))
    assert owner.poll(SECOND_NS) == Twist(0.1, 0.0)
    owner.close()


def test_nothing_but_a_socket_is_replaced(tmp_path: Path) -> None:
    (tmp_path / "notes").write_text("mine")
    with pytest.raises(OSError, match="in use"):
        unix_socket(tmp_path / "notes")
    assert (tmp_path / "notes").read_text() == "mine"


def test_a_port_that_is_taken_leaves_no_socket_open() -> None:
    with udp_socket(0) as heard, pytest.raises(OSError, match="in use"):
        udp_socket(heard.getsockname()[1])


class Pad:
    """A joystick: a terminal without manners, on which stands what the kernel would say."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / "js0"
        self.wishes = JoystickWishes(self.path, JoystickLayout())
        self.plug()

    def plug(self) -> None:
        self._master, slave = os.openpty()
        tty.setraw(slave)
        self.path.unlink(missing_ok=True)
        self.path.symlink_to(os.ttyname(slave))
        self._slave = slave

    def say(self, *events: tuple[int, int, int]) -> None:
        """(value, type, number) each."""
        os.write(self._master, b"".join(struct.pack("<IhBB", 1234, *event) for event in events))

    def unplug(self) -> None:
        os.close(self._master)
        os.close(self._slave)


@pytest.fixture
def pad(tmp_path: Path) -> Iterator[Pad]:
    pad = Pad(tmp_path)
    assert pad.wishes.poll(0) == STANDSTILL
    yield pad
    pad.wishes.close()


def test_the_sticks_count_while_the_button_is_held(pad: Pad) -> None:
    pad.say((-32767, AXIS, 1), (16384, AXIS, 0))
    assert pad.wishes.poll(1) == STANDSTILL
    pad.say((1, BUTTON, 4))
    found = pad.wishes.poll(2)
    assert (found.speed, found.turn_rate) == (approx(0.5), approx(-0.75, rel=1e-3))
    pad.say((0, BUTTON, 4))
    assert pad.wishes.poll(3) == STANDSTILL


def test_other_buttons_and_axes_are_nothing_to_it(pad: Pad) -> None:
    pad.say((1, BUTTON, 4), (32767, AXIS, 3), (1, BUTTON, 0), (0, BUTTON, 0))
    assert pad.wishes.poll(1) == STANDSTILL


def test_the_state_that_the_kernel_tells_at_first_counts(pad: Pad) -> None:
    pad.say((1, BUTTON | INITIAL, 4), (-32768, AXIS | INITIAL, 1))
    assert pad.wishes.poll(1).speed == approx(0.5)


def test_an_unplugged_joystick_is_no_wish_and_is_opened_again(pad: Pad) -> None:
    pad.say((1, BUTTON, 4), (-32767, AXIS, 1))
    assert not pad.wishes.poll(1).stands
    pad.unplug()
    assert pad.wishes.poll(2) == STANDSTILL
    assert pad.wishes.refused == {"joystick lost": 1}
    pad.plug()
    pad.wishes.poll(SECOND_NS)
    pad.say((1, BUTTON | INITIAL, 4), (-32767, AXIS | INITIAL, 1))
    assert pad.wishes.poll(SECOND_NS + 1).speed == approx(0.5)


def test_a_joystick_that_is_not_there_is_counted_twice_a_second(tmp_path: Path) -> None:
    wishes = JoystickWishes(tmp_path / "js9", JoystickLayout())
    for now_ns in range(0, SECOND_NS, 20_000_000):
        assert wishes.poll(now_ns) == STANDSTILL
    assert wishes.refused == {"joystick not there": 2}
