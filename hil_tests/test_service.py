"""echogrid run as a systemd service, with the unit that is shipped, on devices of the kernel."""

import os
import pwd
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from pytest import fixture, mark

from hil_tests.conftest import Measure
from hil_tests.kernel import PROJECT, add_vcan, command, node_behind, wait_for
from hil_tests.kernel_devices import KernelDevices, Wall

UNIT = PROJECT / "deploy" / "echogrid.service"
ROBOT = Path(__file__).with_name("service_robot.toml")
UNITS = Path("/run/systemd/system")
OUT = Path("/var/lib/echogrid/map")
START_S = 90.0
WATCHDOG_S = 15.0
"""Longer than on a robot: here a busy host may hold up the whole guest for seconds."""
LOOK_S = 1.0
"""Not oftener: the guest's one processor has other work than to run systemctl."""
ESTIMATES_NS = 50_000_000
CLOCK_STEP_S = 0.1
"""Files are stamped by a coarser clock."""
STATUS = re.compile(r" (\d+)/(\d+) ok\b.* ([\d.]+) Hz")

DROP_IN = """\
[Service]
ExecStart=
ExecStart={python} -m echogrid run {robot} --out {out}
Environment=PYTHONPATH={project}/src
TimeoutStartSec={start_s:.0f}
WatchdogSec={watchdog_s:.0f}
ProtectHome=tmpfs
BindReadOnlyPaths={project} {prefix} {base_prefix}
"""
"""Runs the project as it lies here instead of an installed one, wherever that is, and is patient."""

pytestmark = mark.usefixtures("guest")


@fixture(scope="module")
def robot(devices: KernelDevices) -> None:
    """All that the service's robot.toml names."""
    add_vcan("vcan2")
    devices.can("vcan2", {0: 1.0, 1: 1.0}, ESTIMATES_NS)
    devices.i2c("ring", {0x70: Wall(1.0)})
    devices.serial("front", Wall(2.0))
    wait_for("role ring", lambda: node_behind("ring"))
    wait_for("role front", lambda: node_behind("front"))


@fixture(scope="module")
def service(robot: None) -> Iterator[None]:
    """The service, started and ready. It takes so long that one serves all tests; the last one stops it."""
    install()
    started = subprocess.run(["systemctl", "start", UNIT.name], check=False)
    assert started.returncode == 0, journal()
    yield
    command("systemctl", "stop", UNIT.name)


def install() -> None:
    (UNITS / UNIT.name).write_text(UNIT.read_text(encoding="utf-8"), encoding="utf-8")
    drop_in = UNITS / f"{UNIT.name}.d" / "bench.conf"
    drop_in.parent.mkdir(exist_ok=True)
    text = DROP_IN.format(
        python=sys.executable,
        robot=ROBOT,
        out=OUT,
        project=PROJECT,
        prefix=sys.prefix,
        base_prefix=sys.base_prefix,
        start_s=START_S,
        watchdog_s=WATCHDOG_S,
    )
    drop_in.write_text(text, encoding="utf-8")
    command("systemctl", "daemon-reload")


def shown(name: str) -> str:
    """A property of the service."""
    return command("systemctl", "show", "--value", "--property", name, UNIT.name).strip()


def status() -> "re.Match[str] | None":
    return STATUS.search(shown("StatusText"))


def journal() -> str:
    return command("journalctl", "--no-pager", "--output=cat", f"--unit={UNIT.name}")


def test_it_is_ready_as_its_own_user_and_shows_rate_and_health(service: None, measure: Measure) -> None:
    assert shown("ActiveState") == "active"
    owner = Path("/proc", shown("MainPID")).stat().st_uid
    assert pwd.getpwuid(owner).pw_name == "echogrid"

    def all_well() -> "re.Match[str] | None":
        said = status()
        return said if said and said[1] == said[2] else None

    said = wait_for("a status with all devices well", all_well, START_S, LOOK_S)
    measure(f"service status: {shown('StatusText')}")
    assert float(said[3]) > 0.0


def test_a_hung_loop_is_killed_by_the_watchdog_and_started_again(service: None, measure: Measure) -> None:
    process = shown("MainPID")
    begun = time.monotonic()
    os.kill(int(process), signal.SIGSTOP)
    wait_for("another process", lambda: shown("MainPID") not in ("0", process), START_S, LOOK_S)
    wait_for("readiness", lambda: shown("ActiveState") == "active", START_S, LOOK_S)
    measure(f"hung service: ready again after {time.monotonic() - begun:.0f} s")
    assert "Watchdog timeout" in journal()
    assert shown("NRestarts") == "1"
    wait_for("a status", status, START_S, LOOK_S)


def test_a_map_is_written_on_stop(service: None) -> None:
    wait_for("a status", status, START_S, LOOK_S)
    begun_s = time.time()
    command("systemctl", "stop", UNIT.name)
    wait_for("an orderly end", lambda: "Deactivated successfully" in journal().rpartition("Stopping ")[2])
    for name in ("map.yaml", "map.pgm", "map.png", "map.npz", "report.json"):
        assert (OUT / name).stat().st_size > 0
        assert (OUT / name).stat().st_mtime >= begun_s - CLOCK_STEP_S
