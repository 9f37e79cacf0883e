"""What is said of a CAN bus, by what happened on it."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import replace

from pytest import fixture, mark

from echogrid.drivers.device import State
from echogrid.drivers.transports.can_link import BusState, CanLink
from echogrid.drivers.transports.can_supervisor import LOOK_EVERY_NS, CanSupervisor, down

MS = 1_000_000
NONE: Mapping[str, int] = {}
GOOD = CanLink(3, True, "can", 250_000, 100, BusState.ERROR_ACTIVE, (0, 0), {"bus-offs": 2, "overruns": 5})
BUS_OFF = 0x040, bytes(8)
RESTARTED = 0x100, bytes(8)
PASSIVE = 0x004, bytes([0, 0x20, 0, 0, 0, 0, 0, 0])
ACTIVE = 0x004, bytes([0, 0x40, 0, 0, 0, 0, 0, 0])
UNACKNOWLEDGED = 0x0A8, bytes(8)


def watched(link: CanLink | None = GOOD, bitrate: int = 250_000) -> CanSupervisor:
    bus = CanSupervisor("can0", bitrate, Counter())
    bus.opened(0, link)
    bus.heard(0, 1, 0)
    return bus


@fixture
def bus() -> CanSupervisor:
    return watched()


def state(bus: CanSupervisor, now_ns: int = 0) -> State:
    return bus.condition(now_ns).state


def test_a_bus_of_which_nothing_bad_is_known_is_well(bus: CanSupervisor) -> None:
    assert (state(bus), bus.condition(0).message) == (State.WELL, "")


def test_a_bus_off_is_told_and_nothing_is_sent_until_the_restart(bus: CanSupervisor) -> None:
    bus.erred(*BUS_OFF)
    assert state(bus) is State.BUS_OFF
    assert not bus.may_send(1_000_000 * MS)
    bus.erred(*RESTARTED)
    assert state(bus) is State.WELL
    assert bus.may_send(0)


def test_the_kernel_s_word_ends_a_bus_off_of_which_no_restart_was_told(bus: CanSupervisor) -> None:
    bus.erred(*BUS_OFF)
    assert bus.looked(LOOK_EVERY_NS, GOOD) == ""
    assert state(bus) is State.WELL


def test_the_kernel_s_word_is_enough_for_a_bus_off(bus: CanSupervisor) -> None:
    assert bus.looked(LOOK_EVERY_NS, replace(GOOD, state=BusState.BUS_OFF)) == ""
    assert state(bus) is State.BUS_OFF


def test_a_bus_off_that_stays_comes_with_the_line_that_mends_it() -> None:
    bus = watched(replace(GOOD, restart_ms=0, bitrate=500_000), 500_000)
    bus.erred(*BUS_OFF)
    assert (
        "sudo ip link set can0 down && sudo ip link set can0 up type can bitrate 500000 restart-ms 100"
        in bus.condition(0).message
    )


def test_a_bus_off_that_ends_by_itself_says_so(bus: CanSupervisor) -> None:
    bus.erred(*BUS_OFF)
    assert "started again after 100 ms" in bus.condition(0).message
    assert "sudo" not in bus.condition(0).message


def test_error_passive_is_told_until_it_is_over(bus: CanSupervisor) -> None:
    bus.erred(*PASSIVE)
    assert state(bus) is State.ERROR_PASSIVE
    assert bus.may_send(0)
    bus.erred(*UNACKNOWLEDGED)
    assert state(bus) is State.ERROR_PASSIVE
    bus.erred(*ACTIVE)
    assert state(bus) is State.WELL


def test_silence_is_told_after_a_second_and_ends_with_a_frame(bus: CanSupervisor) -> None:
    assert state(bus, 1000 * MS) is State.WELL
    assert state(bus, 1001 * MS) is State.SILENT
    bus.heard(1001 * MS, 1, 0)
    assert state(bus, 1002 * MS) is State.WELL


def test_what_is_no_frame_does_not_end_a_silence(bus: CanSupervisor) -> None:
    bus.heard(1001 * MS, 0, 1)
    assert state(bus, 1001 * MS) is State.SILENT


def test_after_each_refusal_sending_waits_longer(bus: CanSupervisor) -> None:
    now_ns, waits = 0, []
    for _ in range(5):
        bus.refused(now_ns)
        started_ns = now_ns
        while not bus.may_send(now_ns):
            now_ns += 10 * MS
        waits.append((now_ns - started_ns) // MS)
    assert waits == [100, 200, 500, 1000, 1000]
    assert state(bus, now_ns) is State.CONGESTED


def test_what_goes_out_ends_the_congestion(bus: CanSupervisor) -> None:
    bus.refused(0)
    bus.sent()
    assert state(bus) is State.WELL
    assert bus.may_send(0)


def test_more_noise_than_frames_is_garbled_until_the_next_look(bus: CanSupervisor) -> None:
    bus.heard(0, 20, 30)
    bus.looked(LOOK_EVERY_NS, GOOD)
    assert state(bus) is State.GARBLED
    bus.heard(0, 20, 0)
    bus.looked(2 * LOOK_EVERY_NS, GOOD)
    assert state(bus) is State.WELL


def test_a_little_noise_is_only_counted(bus: CanSupervisor) -> None:
    bus.heard(0, 0, 10)
    bus.looked(LOOK_EVERY_NS, GOOD)
    assert state(bus) is State.WELL


@mark.parametrize("link", [None, replace(GOOD, index=4)])
def test_an_interface_that_went_away_or_came_anew_is_a_lost_port(
    bus: CanSupervisor, link: CanLink | None
) -> None:
    assert bus.looked(LOOK_EVERY_NS, link).startswith("can0: CAN port lost, was it unplugged?")


def test_an_interface_that_was_set_down_comes_with_the_line_that_mends_it(bus: CanSupervisor) -> None:
    trouble = bus.looked(LOOK_EVERY_NS, replace(GOOD, up=False))
    assert "sudo ip link set can0 up type can bitrate 250000 restart-ms 100" in trouble


@mark.parametrize(
    ("link", "mend"),
    [
        (CanLink(3, False, "can"), "sudo ip link set can0 up type can bitrate 125000 restart-ms 100"),
        (CanLink(3, False, "vcan"), "sudo ip link set can0 up"),
    ],
)
def test_an_interface_is_set_up_as_its_kind_needs_it(link: CanLink, mend: str) -> None:
    assert down("can0", link, 125_000) == f"can0: this CAN interface is down ({mend})"


def test_where_there_is_no_link_none_is_missed() -> None:
    bus = watched(None)
    assert bus.looked(LOOK_EVERY_NS, None) == ""
    assert (state(bus), bus.condition(0).message, bus.link_counts()) == (State.WELL, "", NONE)


def test_another_bit_rate_than_asked_for_is_told_though_all_be_well() -> None:
    condition = watched(bitrate=500_000).condition(0)
    assert condition.state is State.WELL
    assert "can0 has 250000 bit/s, 500000 was asked for" in condition.message
    assert (
        "sudo ip link set can0 down && sudo ip link set can0 up type can bitrate 500000" in condition.message
    )


def test_a_bus_that_would_not_come_back_is_told_though_all_be_well() -> None:
    condition = watched(replace(GOOD, restart_ms=0)).condition(0)
    assert condition.state is State.WELL
    assert "does not come back after a bus-off: sudo ip link set can0 down && " in condition.message


def test_a_virtual_interface_has_nothing_to_set_up() -> None:
    assert watched(CanLink(3, True, "vcan")).condition(0).message == ""


def test_a_silent_bus_is_told_with_what_is_set_up_badly() -> None:
    condition = watched(bitrate=500_000).condition(2000 * MS)
    assert "120 ohm" in condition.message
    assert "500000 was asked for" in condition.message


def test_what_happened_on_the_link_is_counted_from_the_opening_on(bus: CanSupervisor) -> None:
    bus.looked(LOOK_EVERY_NS, replace(GOOD, errors=(128, 3), counts={"bus-offs": 3, "overruns": 9}))
    assert bus.link_counts() == {
        "link: bus-offs": 1,
        "link: overruns": 4,
        "send error counter": 128,
        "receive error counter": 3,
    }
    assert "lost frames on the way in" in bus.condition(0).message


def test_error_frames_are_counted_by_class() -> None:
    counts: Counter[str] = Counter()
    bus = CanSupervisor("can0", 250_000, counts)
    for error in (BUS_OFF, RESTARTED, UNACKNOWLEDGED, (0x1FF, b"")):
        bus.erred(*error)
    assert counts["bus-offs"] == counts["restarts"] == counts["missing acknowledges"] == 2
    assert counts["arbitrations lost"] == counts["send time-outs"] == 1


def test_a_closed_bus_has_no_trouble_and_an_opened_one_none_of_the_old(bus: CanSupervisor) -> None:
    bus.erred(*BUS_OFF)
    bus.refused(0)
    bus.closed()
    assert state(bus, 10_000 * MS) is State.WELL
    bus.opened(10_000 * MS, GOOD)
    assert state(bus, 10_000 * MS) is State.WELL
    assert bus.may_send(10_000 * MS)
