import threading

import pytest

from echogrid.drivers.clock import MonotonicClock
from echogrid.drivers.device import Health, Level, Line, State
from echogrid.drivers.errors import PortError
from echogrid.drivers.supervised import Supervised
from echogrid.runtime.acquisition import DeviceReport, ThreadedAcquisition, device_reports
from echogrid.runtime.pump import PortState, Pump
from echogrid.runtime.reading_queue import ReadingQueue

from .fakes import HandClock, MishapError, Parrot, ScriptedPort

LONG_S = 10.0


class PatientPort(ScriptedPort):
    """A port which waits for `wake` when it has nothing to give, and tells when its script is done."""

    def __init__(self, script: list[object]) -> None:
        super().__init__(script)
        self.done = threading.Event()
        self.threads: set[str] = set()

    def read(self, timeout_s: float) -> list[bytes]:
        self.threads.add(threading.current_thread().name)
        if not self.script:
            self.done.set()
            threading.Event().wait(timeout_s)
        return list(super().read(timeout_s))


def pump_on(port: ScriptedPort, parrot: Parrot, queue: ReadingQueue) -> Pump[bytes, bytes]:
    return Pump(Line(f"line of {parrot.name}", [parrot]), port, MonotonicClock(), queue.put)


def reported(pump: Pump[bytes, bytes]) -> DeviceReport:
    (report,) = device_reports([pump], 0)
    return report


def test_each_bus_has_its_own_thread_which_ends_with_the_context() -> None:
    queue = ReadingQueue()
    ports = [PatientPort([b"x"]), PatientPort([b"y"])]
    pumps = [pump_on(port, Parrot(name), queue) for port, name in zip(ports, "ab", strict=True)]
    before = threading.active_count()
    with ThreadedAcquisition(pumps, queue) as acquisition:
        assert all(port.done.wait(LONG_S) for port in ports)
        assert sorted(reading.raw for reading in acquisition.drain()) == [b"x", b"y"]
    assert [port.threads for port in ports] == [{"bus line of a"}, {"bus line of b"}]
    assert not any(port.is_open for port in ports)
    assert threading.active_count() == before


def test_stopping_twice_is_harmless_and_what_came_before_can_still_be_drained() -> None:
    queue = ReadingQueue()
    port = PatientPort([b"x"])
    with ThreadedAcquisition([pump_on(port, Parrot(), queue)], queue) as acquisition:
        assert port.done.wait(LONG_S)
        acquisition.stop()
        acquisition.stop()
        assert len(acquisition.drain()) == 1


def test_one_bus_s_mishap_leaves_the_others_and_itself_alive() -> None:
    queue = ReadingQueue()
    ports = PatientPort([b"x", MishapError("ouch"), b"y"]), PatientPort([b"z"])
    pumps = [pump_on(port, Parrot(name), queue) for port, name in zip(ports, "ab", strict=True)]
    with ThreadedAcquisition(pumps, queue) as acquisition:
        assert all(port.done.wait(LONG_S) for port in ports)
        assert sorted(reading.raw for reading in acquisition.drain()) == [b"x", b"y", b"z"]
        assert [report.health.counts["port lost"] for report in acquisition.report(0)] == [1, 0]


def test_overflow_is_handed_out() -> None:
    queue = ReadingQueue(1)
    port = PatientPort([b"x", b"y", b"z"])
    with ThreadedAcquisition([pump_on(port, Parrot(), queue)], queue) as acquisition:
        assert port.done.wait(LONG_S)
        assert [reading.raw for reading in acquisition.drain()] == [b"z"]
        assert [reading.raw for reading in acquisition.drain_overflow()] == [b"x", b"y"]


@pytest.mark.parametrize("trouble", [PortError("/dev/fake: gone (plug it in)"), MishapError("ouch")])
def test_a_closed_port_is_its_devices_first_trouble(trouble: Exception) -> None:
    pump = Pump(Line("line", [Parrot()]), ScriptedPort([trouble]), HandClock(), lambda _: None)
    assert reported(pump).health.level is Level.OK
    pump.turn()
    pump.turn()
    assert pump.state is PortState.CLOSED
    assert reported(pump).health.level is Level.ERROR
    assert str(trouble) in reported(pump).health.message
    assert reported(pump).health.counts == {"losses": 1, "port lost": 1}


class BusOffPort(ScriptedPort, Supervised):
    """A port that is open, on a bus that is off."""

    def health(self, now_ns: int) -> Health:
        return Health(State.BUS_OFF, "can0: bus-off (mend it)", {"bus-offs": 1})


def test_the_trouble_of_a_bus_is_shown_of_its_devices() -> None:
    pump = Pump(Line("line", [Parrot()]), BusOffPort(), HandClock(), lambda _: None)
    pump.turn()
    assert reported(pump).health == Health(
        State.BUS_OFF, "can0: bus-off (mend it)", {"losses": 0, "bus-offs": 1, "port lost": 0}
    )


def test_a_device_that_cannot_say_how_it_is_is_in_error() -> None:
    pump = Pump(Line("line", [Parrot()]), ScriptedPort(), HandClock(), lambda _: None)
    pump.line.devices[0].health = _bite  # type: ignore[method-assign]
    assert reported(pump).health.level is Level.ERROR
    assert "bitten" in reported(pump).health.message


def _bite(now_ns: int) -> None:
    raise MishapError("bitten")
