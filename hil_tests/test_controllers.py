"""Every emulated motor controller with its driver on the kernel's bus, recorded by candump."""

import signal
import subprocess
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from statistics import median
from typing import Any

from pytest import FixtureRequest, approx, fixture
from tests.drivers.candump import logged, periods
from tests.drivers.controllers import CONTROLLERS, NODES, RATES, STARTS, drift, golden

from echogrid.drivers.bus import CanFrame
from echogrid.drivers.device import Device, State
from echogrid.drivers.readings import Reading, WheelReading
from echogrid.drivers.transports.can import CanPort
from echogrid.emulation.devices.can_node import CanNode
from hil_tests.conftest import Measure
from hil_tests.kernel import add_vcan, command, wait_for
from hil_tests.kernel_devices import KernelDevices
from hil_tests.pumping import Readout

INTERFACE = "vcan_wheels"
LOGS = Path("/run/bench-out/candump")
SECOND_NS = 1_000_000_000
LASTS_NS = 2 * SECOND_NS
JITTER_S = 0.05
"""So late half of the frames may be sent in the guest."""
OFTEN_S = 0.15
"""Frames that come so often come by themselves, or are asked for; how often others come may be chance."""


@dataclass(frozen=True, slots=True)
class Trial:
    """Two controllers of one make that turn, one in each direction, and their drivers."""

    name: str
    devices: KernelDevices
    nodes: Sequence[CanNode]
    drivers: Sequence[Device[CanFrame, CanFrame]]
    readout: Readout
    turned: Mapping[str, Sequence[WheelReading]]
    """What was read, from power-up on, by wheel."""
    frames: Sequence[CanFrame]
    """What candump has recorded of that."""


@fixture(scope="module", params=CONTROLLERS)
def trial(request: FixtureRequest, guest: None) -> Iterator[Trial]:
    add_vcan(INTERFACE, fd=True)
    try:
        with run_up(request.param) as trial:
            yield trial
    finally:
        command("ip", "link", "delete", INTERFACE)


@contextmanager
def run_up(name: str) -> Iterator[Trial]:
    """From power-up until both wheels have turned for a while."""
    controller = CONTROLLERS[name]
    LOGS.mkdir(exist_ok=True)
    log = LOGS / f"{name}.log"
    drivers = [controller.made(wheel) for wheel in NODES]
    options: Mapping[str, Any] = drivers[0].port_options
    with KernelDevices() as devices, closing(CanPort(INTERFACE, **options)) as port:
        nodes = [controller.emulated(wheel, devices.turning(RATES[wheel])) for wheel in NODES]
        readout = Readout(port, *drivers)
        readout.pump.turn()
        with candump(log):
            devices.can_nodes(INTERFACE, nodes)
            turned = by_wheel(readout.until(have_turned, "2 s of both wheels"))
        yield Trial(name, devices, nodes, drivers, readout, turned, logged(log.read_text()))


@contextmanager
def candump(log: Path) -> Iterator[None]:
    """All that passes meanwhile, in a file."""
    with log.open("w") as file, subprocess.Popen(["candump", "-L", INTERFACE], stdout=file) as dump:
        listeners = Path("/proc/net/can/rcvlist_all")
        wait_for("candump", lambda: listeners.read_text().count(INTERFACE) >= 2)
        try:
            yield
        finally:
            dump.send_signal(signal.SIGINT)


def by_wheel(readings: Sequence[Reading]) -> dict[str, list[WheelReading]]:
    """Sorted out."""
    wheels = [reading for reading in readings if isinstance(reading, WheelReading)]
    return {name: [reading for reading in wheels if reading.wheel == name] for name in NODES}


def have_turned(readings: Sequence[Reading]) -> bool:
    """Whether both wheels were read long enough."""
    return all(
        wheel and wheel[-1].stamp_ns - wheel[0].stamp_ns >= LASTS_NS for wheel in by_wheel(readings).values()
    )


def test_both_directions_are_read_right(trial: Trial, measure: Measure) -> None:
    off = {name: drift(readings, RATES[name]) for name, readings in trial.turned.items()}
    for name, readings in trial.turned.items():
        assert abs(off[name]) < CONTROLLERS[trial.name].fineness + JITTER_S * abs(RATES[name])
        assert median(reading.rate for reading in readings) == approx(RATES[name], rel=0.3)
        assert not any(reading.discontinuity for reading in readings[STARTS:])
    now_ns = trial.devices.clock.now_ns()
    assert {driver.health(now_ns).state for driver in trial.drivers} == {State.WELL}
    worst = max(map(abs, off.values()))
    measure(f"{trial.name}: {len(trial.frames)} frames, 6 and -4 rad within {worst:.4f} rad")


def test_candump_shows_what_it_did_when_the_golden_log_was_made(trial: Trial) -> None:
    ours, theirs = periods(trial.frames), periods(logged(golden(trial.name).read_text()))
    assert ours.keys() == theirs.keys()
    regular = {kind: period for kind, period in theirs.items() if period < OFTEN_S}
    assert {kind: ours[kind] for kind in regular} == approx(regular, rel=0.5)


def test_a_power_cycle_is_flagged_and_no_motion(trial: Trial) -> None:
    (node, other), readout = trial.nodes, trial.readout
    heard = readout.take(20)
    trial.devices.fail(node, "off", SECOND_NS)

    def is_back(readings: Sequence[Reading]) -> bool:
        return any(reading.discontinuity for reading in by_wheel(readings)[node.name][:-10])

    heard += readout.until(is_back, "a flag, and ten readings")
    readings = by_wheel(heard)
    steps = list(pairwise(readings[node.name]))
    flagged = [new.angle - old.angle for old, new in steps if new.discontinuity]
    assert 1 <= len(flagged) <= 2  # the second: its boot-up message may come after its first count
    assert flagged == approx([0.0] * len(flagged), abs=1e-6)
    assert all(new.stamp_ns - old.stamp_ns < SECOND_NS for old, new in steps if not new.discontinuity)
    assert not any(reading.discontinuity for reading in readings[other.name])
    assert trial.drivers[0].health(trial.devices.clock.now_ns()).state is State.WELL
