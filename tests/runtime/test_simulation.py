from hypothesis import given
from hypothesis import strategies as st

from echogrid.drivers.bus import NEVER_NS
from echogrid.drivers.clock import JumpingClock
from echogrid.drivers.device import Line
from echogrid.drivers.errors import PortError
from echogrid.drivers.readings import RangeReading
from echogrid.runtime.pump import Pump
from echogrid.runtime.reading_queue import ReadingQueue
from echogrid.runtime.simulation import Simulation

from .fakes import MS, Parrot


class TimedPort:
    """Has one byte at each of its times."""

    def __init__(self, clock: JumpingClock, times_ns: list[int]) -> None:
        self._clock = clock
        self._times_ns = sorted(times_ns)
        self.is_open = False
        self.gone = False

    def open(self) -> None:
        if self.gone:
            raise PortError("gone (bring it back)")
        self.is_open = True

    def close(self) -> None:
        self.is_open = False

    def write(self, items: object) -> None: ...

    def read(self, timeout_s: float) -> list[bytes]:
        if self.gone:
            raise PortError("gone (bring it back)")
        due = [time_ns for time_ns in self._times_ns if time_ns <= self._clock.now_ns()]
        del self._times_ns[: len(due)]
        return [b"."] * len(due)

    def ready_ns(self) -> int:
        return 0 if self.gone else min(self._times_ns, default=NEVER_NS)


class Bench:
    def __init__(self, *times_ns: list[int]) -> None:
        self.clock = JumpingClock()
        self.ports = [TimedPort(self.clock, times) for times in times_ns]
        queue = ReadingQueue()
        lines = [Line(str(index), [Parrot(str(index))]) for index in range(len(times_ns))]
        self.pumps = [
            Pump(line, port, self.clock, queue.put) for line, port in zip(lines, self.ports, strict=True)
        ]
        self.simulation = Simulation(self.clock, self.pumps, queue)

    def heard(self) -> list[tuple[int, str]]:
        readings = self.simulation.drain()
        assert all(isinstance(reading, RangeReading) for reading in readings)
        return [
            (reading.stamp_ns, reading.sensor) for reading in readings if isinstance(reading, RangeReading)
        ]


@given(st.lists(st.lists(st.integers(1, 30), unique=True), min_size=1, max_size=4))
def test_events_come_in_order_of_time_then_of_the_buses(times_ns: list[list[int]]) -> None:
    bench = Bench(*times_ns)
    bench.simulation.sleep_until_ns(30)
    expected = sorted((time_ns, str(index)) for index, times in enumerate(times_ns) for time_ns in times)
    assert bench.heard() == expected
    assert bench.simulation.now_ns() == 30


@given(st.lists(st.integers(1, 100), unique=True), st.lists(st.integers(1, 100)))
def test_into_how_many_sleeps_the_time_is_cut_does_not_matter(times_ns: list[int], cuts: list[int]) -> None:
    whole, cut = Bench(times_ns, [50]), Bench(times_ns, [50])
    for deadline_ns in [*sorted(cuts), 100]:
        cut.simulation.sleep_until_ns(deadline_ns)
    whole.simulation.sleep_until_ns(100)
    assert whole.heard() == cut.heard()


def test_a_lost_port_is_found_again_after_its_back_off() -> None:
    bench = Bench([10 * MS, 20 * MS, 300 * MS])
    bench.simulation.sleep_until_ns(10 * MS)
    bench.ports[0].gone = True
    bench.simulation.sleep_until_ns(15 * MS)
    assert bench.pumps[0].losses == 1
    bench.ports[0].gone = False
    bench.simulation.sleep_until_ns(400 * MS)
    stamps = [stamp_ns for stamp_ns, _ in bench.heard()]
    assert stamps == [10 * MS, 110 * MS, 300 * MS]


def test_stopping_lets_the_ports_go() -> None:
    bench = Bench([1], [2])
    bench.simulation.sleep_until_ns(5)
    bench.simulation.stop()
    bench.simulation.stop()
    assert [port.is_open for port in bench.ports] == [False, False]
