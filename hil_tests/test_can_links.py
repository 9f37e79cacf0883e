"""CAN interfaces of the kernel, down, gone or set up otherwise: told, mended as told, and read again."""

import json
import socket
import struct
import time
from collections.abc import Iterator
from contextlib import closing
from typing import Any

from pytest import fixture, mark, raises

from echogrid.drivers.device import State
from echogrid.drivers.errors import PortError
from echogrid.drivers.transports.can import CanPort
from echogrid.drivers.transports.can_link import CAN_COUNTS, BusState, CanLink, read_link
from hil_tests.can_watch import BITRATE, CONTROLLED, ESTIMATES, HEARTBEAT, VIRTUAL, Watch, mend, mends, send
from hil_tests.conftest import Measure
from hil_tests.kernel import add_vcan, command
from hil_tests.slcan_adapter import SlcanAdapter

FD_PACKET = struct.Struct("=IB3x64s")
IP_COUNTS = ("bus_error", "error_warning", "error_passive", "bus_off", "arbitration_lost", "restarts")
"""CAN_COUNTS, as ip calls them."""

# python-can leaves its socket to the garbage when the interface is not there.
pytestmark = [mark.usefixtures("guest"), mark.filterwarnings("ignore:unclosed <socket:ResourceWarning")]


@fixture
def watch(virtual: str) -> Iterator[Watch]:
    """The virtual one, watched."""
    with closing(Watch(virtual)) as watch:
        yield watch


def turn() -> None:
    """What an ODrive that is idle sends."""
    send(0x001, b"\0\0\0\0\1")
    send(0x009)


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
