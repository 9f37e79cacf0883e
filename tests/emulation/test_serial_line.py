import pytest

from echogrid.drivers.bus import NEVER_NS, Break
from echogrid.emulation.devices.serial_device import SerialDevice

from .line_host import BREAK, MS, Host

BYTE_NS = 10 * 1_000_000_000 // 9600


class Listener(SerialDevice):
    """Notes what it hears, and answers what it is called by."""

    shares_line = True

    def __init__(self, name: str) -> None:
        super().__init__(name, 9600)
        self.heard: list[tuple[int, bytes]] = []
        self.breaks_ns: list[int] = []
        self.others = b""

    def receive(self, data: bytes, now_ns: int) -> None:
        self.heard.append((now_ns, data))
        if data == self.name.encode():
            self.send(b"me" + data, now_ns)

    def receive_break(self, now_ns: int) -> None:
        self.breaks_ns.append(now_ns)

    def overhear(self, data: bytes, now_ns: int) -> None:
        self.others += data

    def _power_up(self, now_ns: int) -> None:
        pass

    def _power_down(self) -> None:
        self.output.stop()

    def _next_ns(self) -> int:
        return NEVER_NS

    def _step(self, now_ns: int) -> None:
        pass


class OneWire(Listener):
    one_wire = True


def test_every_device_hears_the_host_and_one_answers() -> None:
    host = Host(a := Listener("a"), b := Listener("b"))
    assert host.ask(b"b") == b"meb"
    assert a.heard == b.heard == [(BYTE_NS, b"b")]
    assert a.others == b.others == b"meb"


def test_a_byte_takes_its_bits_both_ways() -> None:
    host = Host(Listener("a"))
    host.ask(b"a")
    assert host.came_ns == pytest.approx([n * BYTE_NS for n in (2, 3, 4)], abs=4)


def test_a_break_is_heard_when_it_ends_and_what_follows_waits_for_that() -> None:
    host = Host(a := Listener("a"))
    host.ask(b"x", BREAK, b"y", Break(0.003))
    assert a.breaks_ns == [BYTE_NS + 2 * MS, 2 * BYTE_NS + 5 * MS]
    assert [at_ns for at_ns, _ in a.heard] == [BYTE_NS, 2 * BYTE_NS + 2 * MS]


def test_on_one_wire_the_host_hears_itself_and_a_break_as_a_zero() -> None:
    assert Host(OneWire("a")).ask(BREAK, b"xa") == b"\0xamea"


def test_a_wire_that_carries_no_breaks_lets_its_devices_do_without() -> None:
    device = Listener("a")
    device.needs_breaks = True
    Host(device).line.lose_breaks()
    assert not device.needs_breaks


@pytest.mark.parametrize("verb", ["off", "unplug"])
def test_of_several_one_may_be_gone_and_the_port_stays(verb: str) -> None:
    host = Host(a := Listener("a"), Listener("b"))
    a.fault(verb, 0)
    assert host.line.present
    assert host.line.unplugs == 0
    assert (host.ask(b"a"), host.ask(b"b")) == (b"", b"meb")
    assert a.others == b""
    a.clear(host.now_ns)
    assert host.ask(b"a") == b"mea"


def test_one_that_is_unplugged_while_it_speaks_falls_silent() -> None:
    host = Host(a := Listener("a"), Listener("b"))
    assert host.ask(b"a", within_ns=2 * BYTE_NS) == b"m"
    a.fault("unplug", host.now_ns)
    assert host.wait(20 * MS) == b""


def test_an_unplugged_adapter_leaves_all_without_power_and_what_was_on_its_way_is_lost() -> None:
    host = Host(a := Listener("a"), b := Listener("b"))
    host.send(BREAK, b"ab")
    host.line.fault("unplug", 0, 50 * MS)
    assert not host.line.present
    assert (a.powered, b.powered) == (False, False)
    assert host.wait(100 * MS) == b""
    assert (host.line.unplugs, a.powered, host.ask(b"a")) == (1, True, b"mea")


def test_what_a_host_leaves_unread_is_kept_up_to_a_limit() -> None:
    host = Host(Listener("a"))
    host.line.send((b"a" * 3000,), 0)
    host.line.advance(20_000 * MS)
    assert len(b"".join(host.line.take(20_000 * MS))) == 4096
