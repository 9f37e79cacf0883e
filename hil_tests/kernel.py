"""The kernel's side of the bench: its modules, and where it put what was plugged in."""

import subprocess
import time
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

MODULES = ("vhci-hcd", "i2c-dev", "i2c-tiny-usb", "srf08", "mb1232", "ftdi_sio", "vcan", "slcan", "can-raw")
PROJECT = Path(__file__).parents[1]
RULES = PROJECT / "udev" / "60-echogrid.rules"
SYSUSERS = PROJECT / "deploy" / "echogrid.sysusers"
RULES_FOLDER = Path("/run/udev/rules.d")
ROLES = Path("/dev/echogrid")
WAIT_S = 30.0
POLL_S = 0.05

Found = TypeVar("Found")


def command(*words: str) -> str:
    """What a command prints. Raises AssertionError with its complaint if it fails."""
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{' '.join(words)}: {done.stderr or done.stdout}"
    return done.stdout


def prepare() -> None:
    """Load the drivers, make the users and groups, and install the udev rules."""
    command("modprobe", "-a", *MODULES)
    command("systemd-sysusers", str(SYSUSERS))
    install_rules(RULES.name, RULES.read_text(encoding="utf-8"))


def install_rules(name: str, rules: str) -> None:
    """Have udev obey them from now on."""
    RULES_FOLDER.mkdir(parents=True, exist_ok=True)
    (RULES_FOLDER / name).write_text(rules, encoding="utf-8")
    command("udevadm", "control", "--reload")


def remove_rules(name: str) -> None:
    """Have udev forget them."""
    (RULES_FOLDER / name).unlink()
    command("udevadm", "control", "--reload")


def add_vcan(name: str, fd: bool = False) -> None:
    """A virtual CAN interface, up; with or without CAN-FD."""
    command("ip", "link", "add", name, "mtu", "72" if fd else "16", "type", "vcan")
    command("ip", "link", "set", name, "up")


def wait_for(
    what: str, look: Callable[[], Found | None], timeout_s: float = WAIT_S, poll_s: float = POLL_S
) -> Found:
    """The first thing found that is not empty. Raises AssertionError if it does not come in time."""
    give_up = time.monotonic() + timeout_s
    while not (found := look()):
        assert time.monotonic() < give_up, f"{what}: not within {timeout_s:.0f} s"
        time.sleep(poll_s)
    return found


def node_of(subsystem: str, serial: str) -> Path:
    """The device node that the kernel made for the USB device of that serial number."""
    return wait_for(f"{subsystem} {serial}", lambda: find_node(subsystem, serial))[0]


def find_node(subsystem: str, serial: str) -> list[Path]:
    """The same, if it is there."""
    return [
        Path("/dev") / entry.name
        for entry in Path("/sys/class", subsystem).iterdir()
        if serial_of(entry) == serial and (Path("/dev") / entry.name).exists()
    ]


def serial_of(entry: Path) -> str | None:
    """The serial number of the USB device behind a device in /sys."""
    for folder in entry.resolve().parents:
        if (folder / "serial").exists():
            return (folder / "serial").read_text().strip()
    return None


def node_behind(role: str) -> Path | None:
    """The node that a role stands for, if it is there."""
    link = ROLES / role
    return link.resolve() if link.exists() else None
