"""EERUF's promise on the emulated buses: what counts is when sound leaves, not when a turn was to begin."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import combinations

import pytest

from echogrid.drivers.clock import JumpingClock
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.robot import EmulatedRobot, RangerSpec
from echogrid.emulation.scene import Echo
from echogrid.runtime import lines, robot_file
from echogrid.runtime.config import Config, FiringConfig
from echogrid.runtime.emulated import DEFAULT_ROBOT, robot_spec
from echogrid.runtime.errors import ConfigError
from echogrid.runtime.firing import Plan
from echogrid.runtime.firing_patterns import PATTERNS
from echogrid.runtime.firing_times import CYCLE_NS
from echogrid.runtime.hardware_config import BusConfig, SensorConfig
from echogrid.runtime.loop import SECOND_NS
from echogrid.runtime.pump import Pump
from echogrid.runtime.reading_queue import ReadingQueue
from echogrid.runtime.simulation import Simulation

SPEED = 343.2
SET_UP_S, SECONDS = 1, 8
AGREEMENT = FiringConfig().agreement_m
NEEDED_NS = 2 * AGREEMENT / SPEED * 1e9
"""By which t_j - t_i must change, so that what is heard moves by more than readings may differ."""


@dataclass(frozen=True)
class Ring:
    """Rangers of one kind all around, on one bus or dealt out to several."""

    driver: str
    count: int
    settings: Mapping[str, int]
    first_address: int = 1
    kind: str = "serial"
    reach: float = 1.5
    buses: int = 1

    def config(self, firing: FiringConfig) -> Config:
        """The robot with these in place of its own."""
        base = robot_file.load(DEFAULT_ROBOT)
        sensors = (
            SensorConfig(
                f"r{n}",
                0.0,
                0.0,
                360.0 * n / self.count,
                half_angle_deg=8.0,
                min_m=0.3,
                max_m=self.reach,
                driver=self.driver,
                bus=f"bus{n % self.buses}",
                settings={"address": self.first_address + n, **self.settings},
            )
            for n in range(self.count)
        )
        wheels = next(bus for bus in base.bus if bus.kind == "can")
        own = (BusConfig(f"bus{n}", self.kind, f"bus{n}") for n in range(self.buses))  # type: ignore[arg-type]  # one of the literals
        return replace(base, bus=(wheels, *own), sensor=tuple(sensors), firing=firing)


RINGS = {
    "sixteen SRF08, one echo": Ring("srf08", 16, {"echoes": 1}, 0x70, "i2c", 6.0),
    "sixteen SRF08, all echoes": Ring("srf08", 16, {"echoes": 17}, 0x70, "i2c", 6.0),
    "sixteen SRF08, all echoes, two buses": Ring("srf08", 16, {"echoes": 17}, 0x70, "i2c", 6.0, buses=2),
    "four URM14": Ring("urm14", 4, {"baud": 19_200}),
    "four URM15": Ring("urm15", 4, {"baud": 115_200}, reach=5.0),
    "eight URM15": Ring("urm15", 8, {"baud": 115_200}, reach=5.0),
    "four SRF02 on a line": Ring("srf02-serial", 4, {}),
    "four DYP": Ring("dyp-rs485", 4, {}),
}

rings = pytest.mark.parametrize("ring", RINGS.values(), ids=RINGS.keys())


def pinged(config: Config) -> Mapping[str, list[int]]:
    """When each ranger's sound left, with drivers and emulators joined on the jumping clock."""
    clock, queue = JumpingClock(SECOND_NS), ReadingQueue()
    times: dict[str, list[int]] = {sensor.name: [] for sensor in config.sensor}

    def surroundings_of(ranger: RangerSpec) -> Surroundings:
        return Surroundings(lambda _: (Echo(1.0, 40.0, "wall"),), SPEED, ping=times[ranger.name].append)

    robot = EmulatedRobot(robot_spec(config), surroundings_of, lambda _side: lambda _now_ns: 0.0, seed=1)
    ports = robot.ports(clock)
    pumps = [Pump(line, ports[line.name], clock, queue.put) for line in lines.lines(config)]
    Simulation(clock, pumps, queue).sleep_until_ns(SECONDS * SECOND_NS)
    return times


def by_cycle(plan: Plan, times: Mapping[str, list[int]]) -> list[Mapping[int, int]]:
    """The same by the numbers of the turns, once all are set up."""
    from_ns = (SET_UP_S + 1) * SECOND_NS + 2 * plan.period_ns
    numbered: list[Mapping[int, int]] = []
    for name, slot in plan.slots.items():
        first = from_ns // plan.period_ns
        turns = range(first, SECONDS * SECOND_NS // plan.period_ns - 1)
        fired = ((n, [t for t in times[name] if 0 <= t - slot.planned_ns(n) <= 20_000_000]) for n in turns)
        numbered.append({n: found[0] for n, found in fired if len(found) == 1})
        assert len(numbered[-1]) == len(turns)
    return numbered


def least_change_ns(fired: list[Mapping[int, int]]) -> int:
    """Of t_j - t_i, of all pairs, between cycles of PATTERNS in a row."""
    return min(
        abs((other[n] - own[n]) - (other[n + apart] - own[n + apart]))
        for own, other in combinations(fired, 2)
        for apart in range(1, PATTERNS)
        for n in own
        if n + apart in own
    )


@rings
def test_what_is_heard_of_others_jumps_however_busy_the_bus_is(ring: Ring) -> None:
    config = ring.config(FiringConfig(mode="eeruf"))
    assert least_change_ns(by_cycle(lines.plan_of(config), pinged(config))) > 1.5 * NEEDED_NS


@rings
def test_and_every_ping_is_as_late_as_any_other_of_its_ranger(ring: Ring) -> None:
    config = ring.config(FiringConfig(mode="eeruf"))
    plan = lines.plan_of(config)
    fired = by_cycle(plan, pinged(config))
    for slot, own in zip(plan.slots.values(), fired, strict=True):
        late_ns = [time_ns - slot.planned_ns(number) for number, time_ns in own.items()]
        assert max(late_ns) - min(late_ns) < 100_000


def test_a_bus_that_is_too_busy_for_a_tenth_of_a_second_is_told_which_cycle_would_do() -> None:
    ring = RINGS["sixteen SRF08, all echoes"]
    with pytest.raises(ConfigError, match="every turn finds bus 'bus0' idle"):
        lines.lines(ring.config(FiringConfig(mode="eeruf", cycle_ms=100.0)))
    assert lines.plan_of(ring.config(FiringConfig(mode="eeruf"))).period_ns > CYCLE_NS
