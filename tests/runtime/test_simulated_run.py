import json
from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import pytest

from echogrid.drivers.device import Level
from echogrid.drivers.readings import RangeReading
from echogrid.emulation.robot import EmulatedRobot
from echogrid.mapping.reckoning import YawRate
from echogrid.mapping.wheel_pair import WheelAngles
from echogrid.runtime import robot_file
from echogrid.runtime.command_line import main
from echogrid.runtime.config import Config
from echogrid.runtime.emulated import DEFAULT_ROBOT
from echogrid.runtime.service import Run
from echogrid.runtime.simulated_run import START_NS, simulated_run

from .conftest import simulate
from .fakes import SECOND

OUTPUTS = {"map.yaml", "map.pgm", "map.png", "map.npz", "trajectory.tum", "report.json"}
LOGS = {"robot.toml", "ranges.csv", "wheels.csv"}
FAULT_NS = START_NS + SECOND
FOR_NS = 8 * SECOND // 5
END_S = 6.0
ALARMING = ("off", "unplug", "garbage", "encoder_lost")
"""A device that is `delayed` does not know it."""


@pytest.fixture(scope="module")
def config() -> Config:
    return robot_file.load(DEFAULT_ROBOT)


class Saboteur:
    """Lets devices fail at a time, and looks at all of them at every tick."""

    def __init__(self, run: Run, robot: EmulatedRobot, names: list[str], verb: str) -> None:
        self._run = run
        self._robot = robot
        self._names = names
        self._verb = verb
        self.ailing: set[str] = set()
        self.counts_before: dict[str, Mapping[str, int]] = {}
        self.read_at_last: Counter[str] = Counter()

    def put(
        self, ranges: tuple[RangeReading, ...], wheels: tuple[WheelAngles, ...], _: tuple[YawRate, ...]
    ) -> None:
        now_ns = self._run.clock.now_ns()
        reports = self._run.acquisition.report(now_ns)
        assert self._run.fusion.ledger.balances(self._run.fusion.waiting)
        if now_ns < FAULT_NS:
            return
        if not self.counts_before:
            self.counts_before = {report.device: report.health.counts for report in reports}
            for name in self._names:
                self._robot.fault(name, self._verb, now_ns, FOR_NS)
        self.ailing |= {report.device for report in reports if report.health.level is not Level.OK}
        if now_ns > START_NS + (END_S - 1.0) * SECOND:
            self.read_at_last.update(reading.sensor for reading in ranges)
            self.read_at_last["wheels"] += len(wheels)


def sabotage(config: Config, verb: str, of_buses: bool = False) -> tuple[Run, Saboteur, list[str]]:
    """Every device, or every bus, that knows the verb fails at once, and comes back."""
    run, robot = simulated_run(config, 3)
    buses = {bus.name for bus in config.bus}
    names = [name for name, verbs in robot.verbs().items() if verb in verbs and (name in buses) == of_buses]
    saboteur = Saboteur(run, robot, names, verb)
    run.sinks = (saboteur,)
    run.go(END_S, lambda _: None)
    return run, saboteur, names


def assert_all_is_well_again(run: Run, saboteur: Saboteur) -> None:
    reports = run.acquisition.report(run.clock.now_ns())
    assert [report.device for report in reports if report.health.level is not Level.OK] == []
    assert all(saboteur.read_at_last[report.device] for report in reports if report.bus != "wheel_bus")
    assert saboteur.read_at_last["wheels"] > 50
    assert (run.loop.in_time, run.loop.late, run.loop.skipped) == (END_S * 50 - 1, 0, 0)
    assert run.fusion.ledger.balances(0)


@pytest.mark.parametrize("verb", ["off", "unplug", "garbage", "delayed", "encoder_lost"])
def test_every_device_survives_every_fault_and_the_loop_does_not_notice(config: Config, verb: str) -> None:
    run, saboteur, names = sabotage(config, verb)
    assert len(names) == (2 if verb == "encoder_lost" else 14)
    if verb in ALARMING:
        assert saboteur.ailing >= set(names)
        assert all(
            report.health.counts != saboteur.counts_before[report.device]
            for report in run.acquisition.report(run.clock.now_ns())
        )
    assert_all_is_well_again(run, saboteur)


def test_every_bus_survives_being_unplugged_and_the_losses_are_counted(config: Config) -> None:
    run, saboteur, names = sabotage(config, "unplug", of_buses=True)
    assert set(names) == {bus.name for bus in config.bus}
    reports = run.acquisition.report(run.clock.now_ns())
    assert saboteur.ailing == {report.device for report in reports}
    assert {report.health.counts["port lost"] for report in reports} == {1}
    assert_all_is_well_again(run, saboteur)


def test_two_runs_with_one_seed_write_the_same_bytes(simulated: Path, tmp_path: Path) -> None:
    assert simulate(tmp_path, "3") == 0
    for folder, names in (("out", OUTPUTS), ("log", LOGS)):
        assert {path.name for path in (simulated / folder).iterdir()} == names
        for name in names:
            assert (simulated / folder / name).read_bytes() == (tmp_path / folder / name).read_bytes(), name


def test_another_seed_hears_something_else(simulated: Path, tmp_path: Path) -> None:
    assert simulate(tmp_path, "4") == 0
    for name in ("out/map.npz", "log/ranges.csv"):
        assert (simulated / name).read_bytes() != (tmp_path / name).read_bytes()


def test_the_map_of_its_log_is_the_same_bit_for_bit(simulated: Path, tmp_path: Path) -> None:
    assert main(["map", str(simulated / "log"), "--out", str(tmp_path)]) == 0
    assert (tmp_path / "map.npz").read_bytes() == (simulated / "out/map.npz").read_bytes()
    assert (tmp_path / "map.pgm").read_bytes() == (simulated / "out/map.pgm").read_bytes()
    run, offline = (
        json.loads((folder / "report.json").read_text()) for folder in (simulated / "out", tmp_path)
    )
    for key in ("readings", "outcomes", "fused", "dropped", "balances"):
        assert run[key] == offline[key]
    assert run["balances"] is True


def test_every_device_is_read_and_every_tick_is_in_time(simulated: Path) -> None:
    report = json.loads((simulated / "out/report.json").read_text())
    assert len(report["readings_by_device"]) == 14
    assert all(report["readings_by_device"].values())
    assert report["ticks"] == {"in_time": 399, "late": 0, "skipped": 0}
    assert {device["level"] for device in report["devices"].values()} == {"OK"}


def test_behind_a_gear_the_emulated_wheels_take_the_robot_the_same_way() -> None:
    config = robot_file.load(DEFAULT_ROBOT)
    geared = replace(config, wheel=tuple(replace(wheel, gear=-4.0) for wheel in config.wheel))
    ways = []
    for each in (config, geared):
        run, _ = simulated_run(each, 1)
        run.go(6.0, lambda _: None)
        ways.append(run.travelled)
    assert ways[0] > 1.0
    assert ways[1] == pytest.approx(ways[0], abs=0.01)
