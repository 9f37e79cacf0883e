"""Firing plans on the jumping clock: the drivers keep their turns, on emulated buses and devices."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import pytest

from echogrid.runtime import offline, robot_file
from echogrid.runtime.config import Config, FiringConfig
from echogrid.runtime.emulated import DEFAULT_ROBOT
from echogrid.runtime.evaluation import Tape, recorded
from echogrid.runtime.lines import plan_of
from echogrid.runtime.service import Run
from echogrid.runtime.simulated_run import simulated_run

SECONDS = 4.0
SET_UP_S = 0.3
RINGS = [f"ring_{angle}" for angle in range(0, 360, 45)]


def configured(firing: FiringConfig, driver: str = "srf08") -> Config:
    config = robot_file.load(DEFAULT_ROBOT)
    sensors = (replace(sensor, driver=driver) if sensor.name in RINGS else sensor for sensor in config.sensor)
    return replace(config, firing=firing, sensor=tuple(sensors))


def driven(config: Config) -> tuple[Run, Tape, Mapping[str, Counter[str]]]:
    """The run, what it took in, and the counts of each device."""
    run, _ = simulated_run(config, seed=2)
    tape = Tape()
    run.sinks = (tape,)
    run.go(SECONDS, lambda _: None)
    reports = run.acquisition.report(run.clock.now_ns())
    return run, tape, {each.device: Counter(each.health.counts) for each in reports}


@pytest.mark.parametrize(
    "firing",
    [
        FiringConfig(),
        FiringConfig(mode="eeruf"),
        FiringConfig(mode="eeruf", jitter_ms=10.0),
        FiringConfig(mode="together"),
        FiringConfig(mode="together", general_call=True),
    ],
    ids=["groups", "eeruf", "with chance", "together", "general call"],
)
def test_every_ranger_fires_in_every_cycle(firing: FiringConfig) -> None:
    config = configured(firing)
    _, _, counts = driven(config)
    cycles = (SECONDS - SET_UP_S) * 1e9 / plan_of(config).period_ns
    for name in RINGS:
        assert counts[name]["echo"] + counts[name]["no echo"] >= cycles
        assert counts[name]["missed slots"] == counts[name]["failed to fire"] == 0


def test_what_was_verified_live_is_verified_from_the_log() -> None:
    config = configured(FiringConfig(mode="eeruf"))
    run, tape, _ = driven(config)
    made = offline.build(recorded(config, tape))
    live = run.fusion.map_image()
    assert run.fusion.ledger.dropped["unverified"] > 0
    assert made.ledger.dropped["unverified"] == run.fusion.ledger.dropped["unverified"]
    assert made.image.occupancy.tobytes() == live.occupancy.tobytes()
    assert made.image.unknown.tobytes() == live.unknown.tobytes()


def test_rangers_that_can_listen_measure_the_crosstalk_and_it_stays_out_of_the_log() -> None:
    run, tape, counts = driven(configured(FiringConfig(mode="together", listen_every=4), "srf02"))
    report: dict[str, Any] = run.report([])["crosstalk"]
    assert sorted(report) == sorted(RINGS)
    for name in RINGS:
        assert report[name]["listened"] == counts[name]["listened"] >= 6
    assert sum(each["heard_foreign"] for each in report.values()) > 0
    assert not any(reading.listened for reading in tape.ranges)
    assert run.fusion.ledger.balances(0)
