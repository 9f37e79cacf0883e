"""Where the tests run: in the guest (--guest), on real ports (--bench), or on any host."""

from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

from pytest import Config, FixtureRequest, Item, Parser, TerminalReporter, fixture, mark

from echogrid.drivers.transports.can_link import read_link
from hil_tests import kernel
from hil_tests.bench import Bench
from hil_tests.can_watch import BITRATE, CONTROLLED, VIRTUAL, Watch
from hil_tests.kernel_devices import KernelDevices
from hil_tests.slcan_adapter import SlcanAdapter

KERNEL_FIXTURE = "guest"
_measured: list[str] = []

Measure = Callable[[str], None]


def pytest_addoption(parser: Parser) -> None:
    """What can be said where they run."""
    group = parser.getgroup("bench")
    group.addoption("--guest", action="store_true", help="this is the guest: its kernel is used")
    group.addoption("--bench", type=Path, metavar="bench.toml", help="real ports instead of emulated ones")


def pytest_collection_modifyitems(config: Config, items: list[Item]) -> None:
    """Outside the guest, nothing of the kernel is touched."""
    if not config.getoption("--guest"):
        for item in items:
            if KERNEL_FIXTURE in getattr(item, "fixturenames", ()):
                item.add_marker(mark.skip(reason="needs the guest's kernel: make hil"))


def pytest_terminal_summary(terminalreporter: TerminalReporter) -> None:
    """Show what was measured."""
    if _measured:
        terminalreporter.section("measured")
        for line in _measured:
            terminalreporter.write_line(line)


@fixture(scope="session")
def bench(request: FixtureRequest) -> Bench | None:
    """The real ports to use, if there are any."""
    path: Path | None = request.config.getoption("--bench")
    return None if path is None else Bench.load(path)


@fixture(scope="session")
def guest() -> None:
    """The guest's kernel and udev, ready for devices."""
    kernel.prepare()


@fixture(scope="module")
def devices(guest: None) -> Iterator[KernelDevices]:
    """Emulated devices which the kernel sees."""
    with KernelDevices() as devices:
        yield devices


@fixture
def virtual() -> Iterator[str]:
    """A CAN interface without a controller."""
    kernel.add_vcan(VIRTUAL)
    yield VIRTUAL
    if read_link(VIRTUAL):
        kernel.command("ip", "link", "delete", VIRTUAL)


@fixture
def adapter() -> Iterator[SlcanAdapter]:
    """A CAN interface with one."""
    with SlcanAdapter(CONTROLLED, BITRATE) as adapter:
        yield adapter


@fixture
def watched(adapter: SlcanAdapter) -> Iterator[Watch]:
    """The one with a controller, watched."""
    with closing(Watch(CONTROLLED)) as watch:
        yield watch


@fixture(scope="session")
def measure() -> Measure:
    """Takes a figure for the summary."""
    return _measured.append
