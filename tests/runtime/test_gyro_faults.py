"""Gyros, driver and emulator together: what they tell of a turn, and how a fault shows."""

from math import cos, radians
from pathlib import Path
from random import Random
from typing import Any

import pytest

from echogrid.drivers import registry
from echogrid.drivers.device import State
from echogrid.drivers.readings import GyroReading
from echogrid.drivers.role import GyroRole
from echogrid.emulation.buses.can_bus import CanBus
from echogrid.emulation.buses.serial_line import SerialLine
from echogrid.emulation.devices.can_node import CanNode
from echogrid.emulation.devices.serial_device import SerialDevice
from echogrid.emulation.models import GYROS
from echogrid.mapping.gyro import Gyro

MS = 1_000_000
SECOND_NS = 1_000_000_000
TICK_NS = 5 * MS
DBC = """VERSION ""

BO_ 416 Gyro: 4 X
 SG_ Yaw_Rate : 0|16@1- (0.01,0) [-327|327] "deg/s" Y
"""


def to_and_fro(now_ns: int) -> float:
    return radians(60.0) * cos(now_ns / SECOND_NS)


class Trial:
    """A driver and its emulated gyro on one bus."""

    def __init__(self, model: str, folder: Path, **shared: Any) -> None:
        (folder / "gyro.dbc").write_text(DBC)
        by_file = {"file": str(folder / "gyro.dbc"), "rate": "Gyro.Yaw_Rate"} if model == "gyro-dbc" else {}
        self.device = GYROS[model].build("gyro", to_and_fro, Random(1), {"bias_dps": 0.0, **shared})
        self.bus = bus_of(self.device)
        self.bus.switch_on(SECOND_NS)
        driver = registry.driver(model)
        self.driver = driver(GyroRole("gyro"), driver.Settings(**by_file, **shared))
        self.now_ns = SECOND_NS
        self.readings: list[GyroReading] = []

    def run(self, seconds: float) -> set[State]:
        """Go on so long; the states that the driver told."""
        states = set()
        end_ns = self.now_ns + round(seconds * SECOND_NS)
        while self.now_ns < end_ns:
            self.now_ns += TICK_NS
            given = self.driver.step(self.now_ns, self.bus.take(self.now_ns)).readings
            self.readings += [reading for reading in given if isinstance(reading, GyroReading)]
            states.add(self.state)
        return states

    @property
    def state(self) -> State:
        return self.driver.health(self.now_ns).state


def bus_of(device: object) -> CanBus | SerialLine:
    if isinstance(device, CanNode):
        return CanBus("bus", 500_000, [device])
    assert isinstance(device, SerialDevice)
    return SerialLine("bus", device)


@pytest.fixture(params=GYROS)
def model(request: pytest.FixtureRequest) -> str:
    if request.param == "gyro-dbc":
        pytest.importorskip("cantools", reason="cantools is not installed")
    return str(request.param)


@pytest.mark.parametrize(
    "shared", [{}, {"unit": "rad/s", "scale": -0.01}, {"scale": 0.5}], ids=["plain", "clockwise", "scaled"]
)
def test_what_it_tells_adds_up_to_the_turn(model: str, tmp_path: Path, shared: dict[str, Any]) -> None:
    trial = Trial(model, tmp_path, **shared)
    assert trial.run(0.2) == {State.SILENT}
    trial.run(20.0)
    gyro = Gyro()
    assert all(gyro.add(reading.stamp_ns, reading.rate) for reading in trial.readings)
    turned = 0.0
    for second in range(12, 20):
        start_ns, end_ns = second * SECOND_NS, (second + 1) * SECOND_NS
        true = sum(to_and_fro(now_ns) * 1e-3 for now_ns in range(start_ns, end_ns, MS))
        found = gyro.turned(start_ns, end_ns)
        assert found == pytest.approx(true, abs=radians(0.35))
        turned += abs(found or 0.0)
    assert turned > 3.0
    assert trial.state is State.WELL


@pytest.mark.parametrize(
    ("verb", "on_a_line", "on_can"),
    [
        ("off", State.SILENT, State.SILENT),
        ("garbage", State.GARBLED, State.WELL),
        ("delayed", State.WELL, State.WELL),
        ("drifting", State.WELL, State.WELL),
        ("stuck", State.WELL, State.WELL),
    ],
)
def test_a_fault_has_its_state_and_goes_with_it(
    model: str, tmp_path: Path, verb: str, on_a_line: State, on_can: State
) -> None:
    trial = Trial(model, tmp_path)
    trial.run(2.0)
    trial.device.fault(verb, trial.now_ns, 3 * SECOND_NS)
    trial.run(2.9)
    assert trial.state is (on_can if model == "gyro-dbc" else on_a_line)
    trial.run(1.0)
    assert trial.state is State.WELL
    assert trial.readings[-1].rate == pytest.approx(to_and_fro(trial.readings[-1].stamp_ns), abs=0.02)


def test_one_that_is_unplugged_from_can_is_silent(tmp_path: Path) -> None:
    pytest.importorskip("cantools", reason="cantools is not installed")
    trial = Trial("gyro-dbc", tmp_path)
    trial.run(2.0)
    trial.device.fault("unplug", trial.now_ns, 2 * SECOND_NS)
    trial.run(1.9)
    assert trial.state is State.SILENT
    trial.run(1.0)
    assert trial.state is State.WELL


def test_a_bad_contact_is_silence_in_turn(model: str, tmp_path: Path) -> None:
    trial = Trial(model, tmp_path)
    trial.run(2.0)
    trial.device.fault("intermittent", trial.now_ns, 10 * SECOND_NS)
    assert State.SILENT in trial.run(10.0)
    trial.run(1.0)
    assert trial.state is State.WELL
