"""The Modbus rangers' drivers and emulated devices, joined in memory on the jumping clock."""

from collections.abc import Mapping
from random import Random
from types import MappingProxyType
from typing import Any

import pytest

from echogrid.drivers import registry
from echogrid.drivers.clock import JumpingClock
from echogrid.drivers.conversation import Conversation
from echogrid.drivers.device import Device, State
from echogrid.drivers.errand import Errand
from echogrid.drivers.readings import Outcome, RangeReading
from echogrid.drivers.role import RangerRole, Slot
from echogrid.drivers.serial_talk import SILENCE
from echogrid.drivers.urm_modbus import address_change
from echogrid.emulation.buses.serial_line import SerialLine
from echogrid.emulation.devices.modbus_slave import ModbusSlave
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.models import RANGERS
from echogrid.emulation.scene import Echo
from echogrid.emulation.wires.memory import MemoryPort
from echogrid.runtime.pump import Pump
from echogrid.runtime.reading_queue import ReadingQueue
from echogrid.runtime.simulation import Simulation

MS = 1_000_000
SECOND = 1000 * MS
WARM, COLD = 343.21, 331.3
REACH = {"urm12": 15.0, "urm13": 9.0, "urm14": 1.5, "urm15": 5.0, "dyp-rs485": 4.5}
STEP = {"urm12": 0.01, "urm13": 0.01, "urm14": 0.0001, "urm15": 0.001, "dyp-rs485": 0.001}
MODELS = tuple(REACH)

PLAIN: Mapping[str, Any] = MappingProxyType({})

every_model = pytest.mark.parametrize("model", MODELS)


class Bench:
    """Some devices on one line in memory."""

    def __init__(self, speed: float = WARM) -> None:
        self.distance: float | None = 1.2345
        self.clock = JumpingClock(SECOND)
        self.slaves: list[ModbusSlave] = []
        self.devices: list[Device[Any, Any]] = []
        self._queue = ReadingQueue()
        self.pings: list[int] = []
        self._surroundings = Surroundings(lambda fire_ns: self._echoes(), speed, ping=self.pings.append)

    def add(
        self, model: str, *, driver: str = "", options: Mapping[str, Any] = PLAIN, **keys: Any
    ) -> "Bench":
        """Another device, and its driver with these settings."""
        kind = RANGERS[model]
        made = kind.build(f"{model} {len(self.slaves)}", self._surroundings, Random(1), options)
        assert isinstance(made, ModbusSlave)
        self.slaves.append(made)
        known = registry.driver(driver or model)
        role = RangerRole(made.name, 0.05, REACH[driver or model], Slot(SECOND, 100 * MS), WARM)
        self.devices.append(known(role, known.Settings(**keys)))
        return self

    def join(self) -> "Bench":
        """Put them on their line."""
        line = SerialLine("port", *self.slaves)
        line.switch_on(self.clock.now_ns())
        port = MemoryPort(line, self.clock)
        pump = Pump(Conversation("port", self.devices), port, self.clock, self._queue.put)
        self._simulation = Simulation(self.clock, [pump], self._queue)
        return self

    def run(self, for_s: float) -> list[RangeReading]:
        """The readings of so much time."""
        self._simulation.sleep_until_ns(self.clock.now_ns() + round(for_s * SECOND))
        return [each for each in self._queue.drain() if isinstance(each, RangeReading)]

    @property
    def state(self) -> State:
        """How the first device is."""
        return self.devices[0].health(self.clock.now_ns()).state

    def _echoes(self) -> tuple[Echo, ...]:
        return () if self.distance is None else (Echo(self.distance, 40.0, "wall"),)


@every_model
@pytest.mark.parametrize("share", [0.3, 0.55, 0.9])
def test_a_wall_is_seen_within_half_a_step(model: str, share: float) -> None:
    bench = Bench().add(model).join()
    bench.distance = share * REACH[model] + 0.00003
    readings = bench.run(4.0)
    assert len(readings) >= 3
    assert {reading.outcome for reading in readings} == {Outcome.ECHO}
    assert max(abs(reading.distance - bench.distance) for reading in readings) <= 0.5001 * STEP[model]


@every_model
def test_nothing_is_no_echo(model: str) -> None:
    bench = Bench().add(model).join()
    bench.distance = None
    assert {reading.outcome for reading in bench.run(4.0)} == {Outcome.NO_ECHO}


@every_model
def test_too_near_is_too_close(model: str) -> None:
    bench = Bench().add(model).join()
    bench.distance = 0.02
    assert {reading.outcome for reading in bench.run(4.0)} == {Outcome.TOO_CLOSE}


@every_model
def test_in_cold_air_the_distance_is_true_all_the_same(model: str) -> None:
    bench = Bench(speed=COLD).add(model).join()
    for reading in bench.run(4.0):
        assert reading.distance == pytest.approx(1.2345, abs=0.51 * STEP[model])


@every_model
def test_the_true_moment_lies_within_the_stamp_s_error(model: str) -> None:
    bench = Bench().add(model).join()
    readings = bench.run(4.0)
    assert len(readings) == len(bench.pings)
    for fired_ns, reading in zip(bench.pings, readings, strict=True):
        met_ns = fired_ns + round(1.2345 / WARM * SECOND)
        assert abs(met_ns - reading.stamp_ns) <= reading.stamp_error_ns + MS // 10


FAULTS = {
    "off": State.MISSING,
    "delayed": State.MISSING,
    "garbage": State.GARBLED,
    "nack_storm": State.FAULTY,
    "stuck": State.WELL,
    "wrong": State.WELL,
}


@every_model
@pytest.mark.parametrize("verb", FAULTS)
def test_each_fault_shows_in_the_state_and_passes(model: str, verb: str) -> None:
    bench = Bench().add(model).join()
    bench.run(4.0)
    assert bench.state is State.WELL
    bench.slaves[0].fault(verb, bench.clock.now_ns(), 10 * SECOND)
    bench.run(4.0)
    states = []
    for _ in range(50):
        bench.run(0.1)
        states.append(bench.state)
    assert max(set(states), key=states.count) is FAULTS[verb]
    bench.run(1.0 + 4.5)
    assert bench.state is State.WELL
    assert bench.run(2.0)[-1].distance == pytest.approx(1.2345, abs=0.51 * STEP[model])


@every_model
def test_a_bad_contact_comes_and_goes(model: str) -> None:
    bench = Bench().add(model).join()
    bench.slaves[0].fault("intermittent", bench.clock.now_ns(), 30 * SECOND)
    states = set()
    for _ in range(290):
        bench.run(0.1)
        states.add(bench.state)
    assert {State.MISSING, State.WELL} <= states
    bench.run(6.0)
    assert bench.state is State.WELL


@every_model
def test_one_that_is_unplugged_from_a_shared_line_is_missing_and_the_other_goes_on(model: str) -> None:
    bench = Bench().add(model).add("urm15", address=0x40, baud=19_200, options={"address": 0x40})
    if model == "dyp-rs485":
        bench = Bench().add(model).add("urm15", options={"baud": 9600}, baud=9600)
    bench.join().run(3.0)
    bench.slaves[0].fault("unplug", bench.clock.now_ns(), 8 * SECOND)
    bench.run(3.0)
    readings = bench.run(4.0)
    assert bench.state is State.MISSING
    assert [reading.outcome for reading in readings] == [Outcome.ECHO] * 4
    bench.run(6.0)
    assert bench.state is State.WELL


@pytest.mark.parametrize(
    ("model", "keys", "states"),
    [
        ("urm12", {"clears_trigger": True}, {State.FAULTY, State.MISSING}),
        ("urm13", {}, {State.FAULTY, State.MISSING}),
        ("urm14", {"clears_trigger": True}, {State.WELL}),
        ("urm15", {"clears_trigger": True}, {State.FAULTY, State.MISSING}),
        ("urm15", {}, {State.WELL}),
        ("dyp-rs485", {}, {State.MISSING, State.STALLED}),
        ("dyp-rs485", {"filtered": True}, {State.MISSING, State.STALLED}),
    ],
)
def test_a_slow_one_shows_where_the_device_tells_that_it_still_pings(
    model: str, keys: dict[str, Any], states: set[State]
) -> None:
    bench = Bench().add(model, **keys).join()
    bench.run(4.0)
    bench.slaves[0].fault("slow", bench.clock.now_ns(), 12 * SECOND)
    bench.run(4.0)
    seen = set()
    for _ in range(60):
        bench.run(0.1)
        seen.add(bench.state)
    assert seen <= states
    bench.run(8.0)
    assert bench.state is State.WELL


@pytest.mark.parametrize("other", ["urm12", "urm13", "urm15"])
def test_another_model_is_not_taken_for_the_one(other: str) -> None:
    bench = Bench().add(other, driver="urm14", options={"address": 0x0C}).join()
    assert bench.run(3.0) == []
    assert bench.state is State.WRONG_DEVICE


def test_one_left_in_automatic_mode_is_set_up() -> None:
    bench = Bench().add("urm14", options={"control": 0}).join()
    assert {reading.outcome for reading in bench.run(4.0)} == {Outcome.ECHO}


def test_firmware_that_leaves_its_trigger_bit_is_told_by_the_key() -> None:
    bench = Bench().add("urm13", options={"clears_trigger": 0}).join()
    bench.run(4.0)
    assert bench.state is State.FAULTY
    trusting = Bench().add("urm13", options={"clears_trigger": 0}, clears_trigger=False).join()
    trusting.run(4.0)
    assert trusting.state is State.WELL


def test_a_urm13_in_millimetres_is_noticed_when_it_is_told_otherwise() -> None:
    bench = Bench().add("urm13", options={"unit_mm": 1.0}).join()
    readings = bench.run(4.0)
    assert {reading.outcome for reading in readings} == {Outcome.INVALID}
    assert "is its unit another?" in readings[0].reason
    assert bench.state is State.FAULTY


def test_all_on_one_line_are_silent_for_each_other_s_frames() -> None:
    bench = Bench()
    for model in ("urm12", "urm13", "urm14", "urm15"):
        bench.add(model)
    readings = bench.join().run(10.0)
    by_name = {
        name: [each.outcome for each in readings if each.sensor == name]
        for name in (slave.name for slave in bench.slaves)
    }
    assert all(len(outcomes) >= 8 and set(outcomes) == {Outcome.ECHO} for outcomes in by_name.values())


@every_model
@pytest.mark.parametrize("parity", ["none", "even"])
def test_an_adapter_that_echoes_and_another_format_change_nothing(model: str, parity: str) -> None:
    format_ = {"parity": parity, "stop_bits": 2, "baud": 9600}
    bench = Bench().add(model, options=format_ | {"echo": 1}, echo=True, **format_).join()
    assert {reading.outcome for reading in bench.run(4.0)} == {Outcome.ECHO}


def test_a_changed_address_counts_from_the_next_power_up_on() -> None:
    bench = Bench().add("urm14").join()
    slave = bench.slaves[0]
    clock = JumpingClock(bench.clock.now_ns())
    line = SerialLine("port", slave)
    transfer = address_change(0x0C, 0x21)

    def course(_: object) -> Any:
        return (yield transfer)

    errand: Errand[Any, Any] = Errand(course, SILENCE, {"baud": 19_200})
    pump = Pump(Conversation("port", [errand]), MemoryPort(line, clock), clock, lambda readings: None)
    Simulation(clock, [pump], ReadingQueue()).sleep_until_ns(clock.now_ns() + SECOND)
    assert errand.outcome.errno == 0
    assert slave.address == 0x0C
    slave.fault("off", clock.now_ns(), 100 * MS)
    line.advance(clock.now_ns() + SECOND)
    assert slave.address == 0x21
