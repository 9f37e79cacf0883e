"""A CAN bus's troubles on the kernel's interfaces: as they are told, mended as they say, and over."""

import gc
import json
import re
import socket
import struct
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from typing import Any

from pytest import fixture, mark, raises

from echogrid.drivers.bus import CanFrame
from echogrid.drivers.device import State
from echogrid.drivers.errors import PortError
from echogrid.drivers.transports.can import CanPort
from echogrid.drivers.transports.can_link import CAN_COUNTS, BusState, CanLink, read_link
from hil_tests.conftest import Measure
from hil_tests.kernel import add_vcan, command
from hil_tests.pumping import WAIT_S, Readout, odrive
from hil_tests.slcan_adapter import SlcanAdapter

VIRTUAL, CONTROLLED = "vcan_sv", "can_sv"
BITRATE = 250_000
PACKET, FD_PACKET = struct.Struct("=IB3x8s"), struct.Struct("=IB3x64s")
BUS_OFF, RESTARTED, CONTROLLER = 0x040, 0x100, 0x004
PASSIVE = b"\0\x20"
"""A controller's problem: too many errors in sending."""
IP_COUNTS = ("bus_error", "error_warning", "error_passive", "bus_off", "arbitration_lost", "restarts")
"""CAN_COUNTS, as ip calls them."""
HEARTBEAT, ESTIMATES = "t00180000000001000000", "t00980000000000000000"
"""Of an ODrive that is idle."""

# python-can leaves its socket to the garbage when the interface is not there.
pytestmark = [mark.usefixtures("guest"), mark.filterwarnings("ignore:unclosed <socket:ResourceWarning")]


@fixture
def virtual() -> Iterator[str]:
    """An interface without a controller."""
    add_vcan(VIRTUAL)
    yield VIRTUAL
    if read_link(VIRTUAL):
        command("ip", "link", "delete", VIRTUAL)


@fixture
def adapter() -> Iterator[SlcanAdapter]:
    """An interface with one."""
    with SlcanAdapter(CONTROLLED, BITRATE) as adapter:
        yield adapter


def send(identifier: int, data: bytes = b"") -> None:
    """By a socket of the kernel's own, on the virtual interface."""
    with socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as sender:
        sender.bind((VIRTUAL,))
        sender.send(PACKET.pack(identifier, 8, data))


def turn() -> None:
    """What an ODrive that is idle sends."""
    send(0x001, b"\0\0\0\0\1")
    send(0x009)


class Watch:
    """An ODrive's driver on an interface, kept going."""

    def __init__(self, interface: str, bitrate: int = BITRATE) -> None:
        self.port = CanPort(interface, bitrate=bitrate)
        self.readout = Readout(self.port, odrive())
        self.pump = self.readout.pump
        self.pump.turn()
        assert self.pump.trouble == ""

    def close(self) -> None:
        """Let the port go."""
        self.readout.close()
        gc.collect()

    def until(self, done: Callable[[], bool], meanwhile: Callable[[], None] = lambda: None) -> float:
        """Go on until it is so; how long that took, s. Raises AssertionError after a while."""
        began_s = time.monotonic()
        while not done():
            assert time.monotonic() < began_s + WAIT_S, (self.health, self.pump.trouble)
            self.pump.turn()
            meanwhile()
        return time.monotonic() - began_s

    def until_state(self, state: State) -> str:
        """Go on until the bus is so; what it says then."""
        self.until(lambda: self.health[0] is state)
        return self.health[1]

    def until_read(self, sending: Callable[[], None]) -> float:
        """Go on until the wheel is read again; how long that took, s."""
        self.readout.readings.clear()
        lasted_s = self.until(lambda: bool(self.readout.readings), sending)
        assert self.pump.trouble == ""
        return lasted_s

    @property
    def health(self) -> tuple[State, str]:
        """The bus's."""
        health = self.port.health(time.monotonic_ns())
        return health.state, health.message

    @property
    def counts(self) -> dict[str, int]:
        """The bus's."""
        return dict(self.port.health(time.monotonic_ns()).counts)


@fixture
def watch(virtual: str) -> Iterator[Watch]:
    """The virtual one, watched."""
    with closing(Watch(virtual)) as watch:
        yield watch


@fixture
def watched(adapter: SlcanAdapter) -> Iterator[Watch]:
    """The one with a controller, watched."""
    with closing(Watch(CONTROLLED)) as watch:
        yield watch


def by_ip(interface: str) -> dict[str, Any]:
    """What iproute2 says of it."""
    (link,) = json.loads(command("ip", "-json", "-details", "-statistics", "link", "show", interface))
    assert isinstance(link, dict)
    return link


def expected(told: dict[str, Any]) -> CanLink:
    """That in our words. The error counters are left out."""
    info, received = told["linkinfo"], told["stats64"]["rx"]
    more, counts = info.get("info_data", {}), info.get("info_xstats", {})
    return CanLink(
        told["ifindex"],
        "UP" in told["flags"],
        info["info_kind"],
        more.get("bittiming", {}).get("bitrate", more.get("bittiming_bitrate")),
        more.get("restart_ms"),
        None if "state" not in more else getattr(BusState, more["state"].replace("-", "_")),
        None,
        {ours: counts[theirs] for ours, theirs in zip(CAN_COUNTS, IP_COUNTS, strict=True) if theirs in counts}
        | {"overruns": received["dropped"] + received["over_errors"]},
        told["mtu"],
        more.get("data_bittiming", {}).get("bitrate"),
    )


def mends(trouble: str) -> list[str]:
    """The commands that a message advises, without sudo."""
    return re.findall(r"sudo (ip [^&()]*\w)", trouble)


def mend(trouble: str) -> None:
    """Do what it says. The kernel's slcan driver refuses restart-ms, as the message allows for."""
    for line in mends(trouble):
        command(*line.replace(" restart-ms 100", "").split())


def test_a_link_is_known_as_iproute2_knows_it(virtual: str, adapter: SlcanAdapter) -> None:
    turn()
    adapter.say("e1a")
    adapter.say("sp000130")
    for state in ("up", "down"):
        for interface in (VIRTUAL, CONTROLLED):
            command("ip", "link", "set", interface, state)
            assert read_link(interface) == expected(by_ip(interface))
    assert read_link("can_nowhere") is None


def test_an_interface_that_is_down_is_told_and_read_again_when_the_advice_is_taken(watch: Watch) -> None:
    watch.until_read(turn)
    command("ip", "link", "set", VIRTUAL, "down")
    watch.until(lambda: bool(mends(watch.pump.trouble)))
    assert watch.pump.trouble == f"{VIRTUAL}: this CAN interface is down (sudo ip link set {VIRTUAL} up)"
    mend(watch.pump.trouble)
    watch.until_read(turn)
    assert watch.pump.losses == 1


def test_an_interface_that_was_deleted_is_read_again_when_it_is_back(watch: Watch, measure: Measure) -> None:
    watch.until_read(turn)
    command("ip", "link", "delete", VIRTUAL)
    watch.until(lambda: "not there" in watch.pump.trouble)
    back_s = time.monotonic() + 2.0
    watch.until(lambda: time.monotonic() > back_s)
    add_vcan(VIRTUAL)
    lasted_s = watch.until(lambda: watch.pump.trouble == "")
    measure(f"a CAN interface that was away for 2 s: open again after {lasted_s:.2f} s")
    assert lasted_s < 1.5
    watch.until_read(turn)
    assert watch.pump.losses == 1


def test_an_interface_of_the_same_name_is_not_taken_for_the_one_before(virtual: str) -> None:
    with closing(CanPort(virtual)) as port:
        port.open()
        before = read_link(virtual)
        command("ip", "link", "delete", virtual)
        add_vcan(virtual)
        after = read_link(virtual)
        assert before and after and before.index != after.index
        with raises(PortError, match="CAN port lost, was it unplugged"):
            for _ in range(20):
                port.read(0.1)
        port.open()
        turn()
        assert len(port.read(1.0)) >= 1


def test_a_link_without_can_fd_is_told_and_used_when_the_advice_is_taken(virtual: str) -> None:
    with closing(CanPort(virtual, fd=True)) as port:
        with raises(PortError, match="CAN-FD") as told:
            port.open()
        mend(str(told.value))
        port.open()
        with socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as sender:
            sender.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FD_FRAMES, 1)
            sender.bind((virtual,))
            sender.send(FD_PACKET.pack(0x123, 12, b"twelve bytes"))
        (frame,) = port.read(1.0)
    assert (frame.fd, frame.data) == (True, b"twelve bytes")


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


def test_a_pulled_adapter_is_told_and_read_again_when_it_is_set_up(
    adapter: SlcanAdapter, watched: Watch
) -> None:
    adapter.unplug()
    watched.until(lambda: "not there" in watched.pump.trouble)
    with SlcanAdapter(CONTROLLED, BITRATE) as another:
        command("ip", "link", "set", CONTROLLED, "down")
        watched.until(lambda: bool(mends(watched.pump.trouble)))
        mend(watched.pump.trouble)
        watched.until_read(lambda: another.say(HEARTBEAT, ESTIMATES))
        assert watched.pump.losses == 1


def test_another_bit_rate_and_no_restart_are_told_with_the_lines_that_mend_them(
    adapter: SlcanAdapter,
) -> None:
    with closing(Watch(CONTROLLED, 500_000)) as watch:
        state, message = watch.health
    assert state is State.WELL
    assert f"{CONTROLLED} has 250000 bit/s, 500000 was asked for" in message
    assert f"sudo ip link set {CONTROLLED} up type can bitrate 500000 restart-ms 100" in message
    assert f"{CONTROLLED} does not come back after a bus-off" in message
