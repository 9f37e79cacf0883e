"""A CAN bus's troubles on the kernel's interfaces: as they are told, mended as they say, and over."""

import socket
import time
from contextlib import closing

from pytest import mark

from echogrid.drivers.bus import CanFrame
from echogrid.drivers.device import State
from echogrid.drivers.transports.can import CanPort
from hil_tests.can_watch import CONTROLLED, ESTIMATES, HEARTBEAT, Watch, mend, send
from hil_tests.slcan_adapter import SlcanAdapter

BUS_OFF, RESTARTED, CONTROLLER = 0x040, 0x100, 0x004
PASSIVE = b"\0\x20"
"""A controller's problem: too many errors in sending."""

# python-can leaves its socket to the garbage when the interface is not there.
pytestmark = [mark.usefixtures("guest"), mark.filterwarnings("ignore:unclosed <socket:ResourceWarning")]


@mark.parametrize(
    ("identifier", "data", "state"),
    [(BUS_OFF, b"", State.BUS_OFF), (CONTROLLER, PASSIVE, State.ERROR_PASSIVE)],
)
def test_an_error_frame_that_passes_is_believed_until_the_controller_starts_again(
    virtual: str, identifier: int, data: bytes, state: State
) -> None:
    # The link is not looked at: a virtual one has no state, and would contradict.
    with closing(CanPort(virtual, look=lambda _: None)) as port:
        port.open()
        send(socket.CAN_ERR_FLAG | identifier, data)
        assert port.read(1.0) == []
        assert port.health(time.monotonic_ns()).state is state
        port.write([CanFrame(0x001, b"")])
        assert port.counts["unsent frames"] == (state is State.BUS_OFF)
        send(socket.CAN_ERR_FLAG | RESTARTED)
        assert port.read(1.0) == []
        assert port.health(time.monotonic_ns()).state is State.WELL
        assert port.counts["error frames"] == 2


def test_an_error_passive_controller_is_told_until_it_is_well(adapter: SlcanAdapter, watched: Watch) -> None:
    adapter.say("sp000130")
    assert "120 ohm" in watched.until_state(State.ERROR_PASSIVE)
    adapter.say("sa000000")
    adapter.say(HEARTBEAT)
    watched.until_state(State.WELL)
    watched.until(lambda: watched.counts["link: error passives"] == 1)
    assert watched.counts["controller problems"] == 2


def test_missing_acknowledges_are_counted(adapter: SlcanAdapter, watched: Watch) -> None:
    adapter.say("e1a")
    watched.until(lambda: watched.counts.get("missing acknowledges") == 1)
    assert watched.counts["error frames"] == 1


def test_a_bus_off_sends_nothing_and_is_over_when_the_advice_is_taken(
    adapter: SlcanAdapter, watched: Watch
) -> None:
    adapter.say("sb000255")
    message = watched.until_state(State.BUS_OFF)
    assert f"{CONTROLLED}: bus-off, and it stays so" in message
    watched.port.write([CanFrame(0x123, b"stale")])
    assert watched.counts["unsent frames"] == 1
    watched.until(lambda: watched.counts["link: bus-offs"] == 1)
    mend(message)
    watched.until_read(lambda: adapter.say(HEARTBEAT, ESTIMATES))
    assert watched.health[0] is State.WELL
    assert b"t123" not in adapter.heard


def test_a_full_queue_is_congestion_and_its_frames_go_out_later(
    adapter: SlcanAdapter, watched: Watch
) -> None:
    adapter.hang()
    frames = [CanFrame(0x100 + number, b"\0" * 8) for number in range(40)]
    watched.port.write(frames)
    state, message = watched.health
    assert (state, watched.counts["unsent frames"] > 0) == (State.CONGESTED, True)
    assert "nobody acknowledges" in message
    adapter.go_on()
    adapter.say(HEARTBEAT)

    def send_again() -> None:
        watched.port.write([CanFrame(0x200, b"fresh")])

    watched.until(lambda: watched.health[0] is State.WELL and b"t2005" in adapter.heard, send_again)
    assert b"t1008" in adapter.heard
    assert b"t1278" not in adapter.heard
