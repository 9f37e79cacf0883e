from collections.abc import Sequence

import pytest

from echogrid.drivers.device import Line
from echogrid.drivers.errors import PortError
from echogrid.drivers.readings import Reading
from echogrid.runtime.pump import PortState, Pump

from .fakes import MS, SECOND, HandClock, MishapError, Parrot, ScriptedPort

LOST = PortError("/dev/fake: lost (plug it in)")


class Bench:
    """A pump on a port that does as it is told."""

    def __init__(self, script: Sequence[object] = (), refusals: int = 0, devices: int = 1) -> None:
        self.clock = HandClock(7 * SECOND)
        self.port = ScriptedPort(script, refusals)
        self.parrots = [Parrot(f"parrot {index}") for index in range(devices)]
        self.readings: list[Reading] = []
        self.pump = Pump(Line("line", self.parrots), self.port, self.clock, self.readings.extend)

    def turns_until(self, state: PortState) -> int:
        """Turn until the port is so; how many ns that took."""
        start_ns = self.clock.time_ns
        for _ in range(1000):
            if self.pump.state is state:
                break
            self.pump.turn()
        assert self.pump.state is state
        return self.clock.time_ns - start_ns


def test_it_opens_its_port_and_carries_readings_and_answers() -> None:
    bench = Bench([b"one", b"two"])
    for _ in range(3):
        bench.pump.turn()
    assert [reading.raw for reading in bench.readings] == [b"one", b"two"]
    assert bench.port.sent == [b"one", b"two"]
    assert (bench.pump.state, bench.pump.trouble, bench.pump.losses) == (PortState.OPEN, "", 0)


def test_a_port_that_is_not_there_is_tried_again_ever_later_up_to_a_second() -> None:
    bench = Bench(refusals=6)
    tried = []
    for _ in range(1000):
        left = bench.port.refusals
        bench.pump.turn()
        if bench.port.refusals < left or bench.pump.state is PortState.OPEN:
            tried.append((bench.clock.time_ns - 7 * SECOND) // MS)
        if bench.pump.state is PortState.OPEN:
            break
    assert tried == [0, 100, 300, 800, 1800, 2800, 3800]
    assert bench.pump.losses == 0


def test_while_the_port_is_closed_no_turn_waits_long() -> None:
    bench = Bench(refusals=6)
    for _ in range(40):
        before_ns = bench.clock.time_ns
        bench.pump.turn()
        assert bench.clock.time_ns - before_ns <= 50 * MS


def test_a_lost_port_is_closed_told_to_every_device_and_found_again() -> None:
    bench = Bench([b"one", LOST, b"two"], devices=2)
    for _ in range(3):
        bench.pump.turn()
    assert (bench.pump.state, bench.port.is_open) == (PortState.CLOSED, False)
    assert bench.pump.trouble == "/dev/fake: lost (plug it in)"
    assert [parrot.losses for parrot in bench.parrots] == [[7 * SECOND], [7 * SECOND]]
    assert bench.turns_until(PortState.OPEN) == 100 * MS
    bench.pump.turn()
    assert [reading.raw for reading in bench.readings] == [b"one", b"one", b"two", b"two"]
    assert (bench.pump.losses, bench.pump.trouble, bench.port.opened) == (1, "", 2)


@pytest.mark.parametrize("error", [MishapError("ouch"), KeyError("x"), ZeroDivisionError()])
def test_a_driver_s_mishap_costs_its_port_a_moment_and_is_told(error: Exception) -> None:
    bench = Bench([b"one", b"two", b"three"])
    bench.pump.turn()
    bench.parrots[0].bite = error
    bench.pump.turn()
    assert bench.pump.state is PortState.CLOSED
    assert bench.pump.trouble == f"line: internal error: {error!r} (please report it)"
    bench.turns_until(PortState.OPEN)
    bench.pump.turn()
    assert [reading.raw for reading in bench.readings] == [b"two"]


def test_a_driver_that_fails_even_at_a_loss_is_contained() -> None:
    bench = Bench([LOST, b"one"])
    bench.parrots[0].lost = _bite  # type: ignore[method-assign]
    bench.pump.turn()
    bench.pump.turn()
    assert bench.pump.state is PortState.CLOSED
    assert "bitten" in bench.pump.trouble
    assert bench.turns_until(PortState.OPEN) == 100 * MS


def test_a_port_that_fails_to_close_is_contained() -> None:
    bench = Bench([LOST])
    bench.port.close = lambda: _bite(0)  # type: ignore[method-assign]
    bench.pump.turn()
    bench.pump.turn()
    assert bench.pump.state is PortState.CLOSED
    assert "bitten" in bench.pump.trouble


def _bite(now_ns: int) -> None:
    raise MishapError("bitten")


class Leaver(Parrot):
    """Is not to be left as it is."""

    def parting(self, now_ns: int) -> Sequence[bytes]:
        return (b"farewell",)


def test_what_a_device_says_last_is_sent_before_its_port_is_closed() -> None:
    bench = Bench()
    bench.pump = Pump(Line("line", [Parrot(), Leaver()]), bench.port, bench.clock, bench.readings.extend)
    bench.turns_until(PortState.OPEN)
    bench.pump.close()
    assert bench.port.sent == [b"farewell"]
    assert not bench.port.is_open
    bench.pump.close()
    assert bench.port.sent == [b"farewell"]
