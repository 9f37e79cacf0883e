"""Each driver on a port: of an emulated device on any host, or of a real one with --bench."""

import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

from pytest import FixtureRequest, MarkDecorator, TempPathFactory, approx, fixture, mark, skip

from echogrid.drivers.clock import MonotonicClock
from echogrid.drivers.device import Device, Level
from echogrid.drivers.readings import Outcome, RangeReading, Reading, WheelReading
from echogrid.emulation.control import request as tell
from echogrid.emulation.robot import BusSpec, EmulatedRobot, RangerSpec, RobotSpec, WheelSpec
from echogrid.emulation.server import CONTROL_SOCKET, Server
from hil_tests.bench import Bench, Entry
from hil_tests.kernel_devices import Wall
from hil_tests.pumping import Readout, a02yyuw, odrive, srf08

DISTANCE, RATE = 1.5, 2.0
TOLERANCE = 0.03
"""m: how far a ranger may be off the true distance."""
OUTAGE_S = 0.5
SPEC = RobotSpec(
    0.1,
    0.4,
    (BusSpec("line", "serial"), BusSpec("wheels", "can"), BusSpec("ring", "i2c")),
    (
        RangerSpec("ahead", "a02yyuw", "line", 0.0, 0.0, 0.0),
        RangerSpec("side", "srf08", "ring", 0.0, 0.0, 0.0),
    ),
    (WheelSpec("wheel", "odrive-0.5", "wheels", "left", {"estimates_ns": 50_000_000}),),
)
BUSES = {"a02yyuw": "line", "srf08": "ring", "odrive": "wheels"}
DRIVERS: dict[str, Callable[[Entry], Device[Any, Any]]] = {
    "a02yyuw": lambda entry: a02yyuw(),
    "srf08": lambda entry: srf08(entry.facts.get("address", 0x70)),
    "odrive": lambda entry: odrive(node=entry.facts.get("node", 0)),
}


@fixture(scope="module")
def served(tmp_path_factory: TempPathFactory) -> Iterator[Path]:
    """The folder of an emulated robot's ports."""
    robot = EmulatedRobot(
        SPEC, lambda _: Wall(DISTANCE).surroundings(), lambda _: lambda now_ns: RATE * now_ns * 1e-9
    )
    folder = tmp_path_factory.mktemp("robot")
    stop = threading.Event()
    with Server(robot, folder, MonotonicClock()) as server:
        thread = threading.Thread(target=server.run, args=(stop,))
        thread.start()
        yield folder
        stop.set()
        thread.join()


@fixture
def entry(bench: Bench | None, request: FixtureRequest) -> Entry:
    """The device that the test is about: a real one, or the emulated robot's."""
    if bench is None:
        bench = emulated(request.getfixturevalue("served"))
    return bench.entry(request.param)


def emulated(folder: Path) -> Bench:
    slcan = {"interface": "slcan", "bitrate": 500_000}
    devices: dict[str, dict[str, Any]] = {
        "a02yyuw": {"port": f"{folder}/line", "distance_m": DISTANCE},
        "srf08": {"port": f"unix:{folder}/ring.sock", "distance_m": DISTANCE},
        "odrive": {"port": f"{folder}/wheels", "options": slcan, "rate_rad_s": RATE},
    }
    return Bench("the emulated robot", devices)


@fixture
def readout(entry: Entry) -> Iterator[Readout]:
    """The device on its port."""
    with closing(Readout(entry.opened(), DRIVERS[entry.device](entry))) as readout:
        yield readout


def of(*devices: str) -> MarkDecorator:
    """Run the test for each of these devices."""
    return mark.parametrize("entry", devices, indirect=True)


def stamps(readings: Sequence[Reading]) -> list[int]:
    return [reading.stamp_ns for reading in readings]


@of("a02yyuw", "srf08", "odrive")
def test_readings_come_in_order_and_the_device_is_well(readout: Readout) -> None:
    readings = readout.take(10)
    (device,) = readout.pump.line.devices
    assert stamps(readings) == sorted(set(stamps(readings)))
    assert device.health(MonotonicClock().now_ns()).level is Level.OK


@of("a02yyuw", "srf08")
def test_a_ranger_measures_the_distance(entry: Entry, readout: Readout) -> None:
    distance = entry.fact("distance_m")
    for reading in readout.ranges(5):
        assert reading.outcome is Outcome.ECHO
        assert reading.distance == approx(distance, abs=TOLERANCE)


@of("a02yyuw", "srf08")
def test_every_ping_is_one_of_the_four_facts(readout: Readout) -> None:
    for reading in readout.ranges(5):
        assert reading.outcome is not Outcome.INVALID, reading
        assert (reading.distance > 0) == (reading.outcome is Outcome.ECHO)


@of("odrive")
def test_a_wheel_turns_at_its_rate(entry: Entry, readout: Readout) -> None:
    rate = entry.fact("rate_rad_s")
    readings = [reading for reading in readout.take(20) if isinstance(reading, WheelReading)]
    turned = readings[-1].angle - readings[0].angle
    assert turned / (readings[-1].stamp_ns - readings[0].stamp_ns) * 1e9 == approx(rate, rel=0.2)


@of("a02yyuw", "srf08", "odrive")
def test_readings_come_back_after_an_unplug(
    bench: Bench | None, entry: Entry, readout: Readout, served: Path
) -> None:
    if bench is not None:
        skip("nobody pulls a cable of a real bench")
    readout.take(2)
    fault = {"fault": BUSES[entry.device], "verb": "unplug", "for_s": OUTAGE_S}
    tell(served / CONTROL_SOCKET, fault)
    readout.until(lambda _: readout.pump.losses > 0, "the loss")
    assert all(isinstance(reading, RangeReading | WheelReading) for reading in readout.take(3))
