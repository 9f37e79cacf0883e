"""The emulated SRF08 behind the kernel's own I2C adapter, judged by the kernel's own driver for it."""

import time
from collections.abc import Iterator
from contextlib import closing
from errno import ENXIO
from pathlib import Path
from statistics import median

from pytest import approx, fixture, mark, raises
from smbus2 import SMBus

from echogrid.drivers.bus import NACK_ERRNOS, I2cMessage, I2cTransfer
from echogrid.drivers.readings import Outcome
from echogrid.drivers.transports.ports import open_port
from hil_tests.conftest import Measure
from hil_tests.kernel import command, node_of, wait_for
from hil_tests.kernel_devices import KernelDevices, Wall
from hil_tests.pumping import Readout, srf08

ADDRESS, OTHER_ADDRESS = 0x70, 0x74
COMMAND, CENTIMETRES = 0, 0x51
RANGING_S = 0.08
DISTANCES = (0.05, 0.77, 1.50, 2.50, 5.50)
NEAR = 0.01
"""m: how well two who measure the same agree."""

pytestmark = mark.usefixtures("guest")


@fixture(scope="module")
def wall() -> Wall:
    return Wall(1.0)


@fixture(scope="module")
def adapter(devices: KernelDevices, wall: Wall) -> Path:
    """The kernel's node for an adapter with a ranger at each of two addresses."""
    devices.i2c("ring", {ADDRESS: wall, OTHER_ADDRESS: wall})
    return node_of("i2c-dev", "ring")


@fixture
def iio(adapter: Path) -> Iterator[Path]:
    """The folder of the kernel's own driver, bound to the ranger."""
    bus = Path("/sys/bus/i2c/devices") / adapter.name
    (bus / "new_device").write_text(f"srf08 {ADDRESS:#x}")
    client = bus / f"{adapter.name.removeprefix('i2c-')}-00{ADDRESS:x}"
    yield wait_for("IIO device", lambda: list(client.glob("iio:device*")))[0]
    (bus / "delete_device").write_text(f"{ADDRESS:#x}")


def read_by_iio(folder: Path) -> float:
    """m."""
    raw, scale = ((folder / f"in_distance_{name}").read_text() for name in ("raw", "scale"))
    return int(raw) * float(scale)


def test_i2cdetect_finds_the_rangers_and_no_others(adapter: Path) -> None:
    rows = command("i2cdetect", "-y", adapter.name.removeprefix("i2c-")).splitlines()[1:]
    cells = [cell for row in rows for cell in row.partition(":")[2].split()]
    assert [cell for cell in cells if cell != "--"] == [f"{ADDRESS:x}", f"{OTHER_ADDRESS:x}"]


@mark.parametrize("distance", DISTANCES)
def test_the_kernels_own_driver_reads_the_ranger(
    iio: Path, wall: Wall, distance: float, measure: Measure
) -> None:
    wall.distance = distance
    read = read_by_iio(iio)
    measure(f"IIO srf08: {distance:.2f} m read as {read:.2f} m")
    assert read == approx(distance, abs=NEAR)


@mark.parametrize("distance", DISTANCES)
def test_our_driver_agrees_with_the_kernels(
    iio: Path, adapter: Path, wall: Wall, distance: float, measure: Measure
) -> None:
    wall.distance = distance
    with closing(open_port("i2c", str(adapter))) as port:
        reading = Readout(port, srf08(ADDRESS)).ranges(1)[0]
    measure(f"our driver: {distance:.2f} m read as {reading.distance:.4f} m")
    assert reading.outcome is Outcome.ECHO
    assert reading.distance == approx(read_by_iio(iio), abs=NEAR)


def test_a_ranger_that_listens_does_not_acknowledge(adapter: Path) -> None:
    with SMBus(str(adapter)) as bus:
        bus.write_byte_data(ADDRESS, COMMAND, CENTIMETRES)
        with raises(OSError) as caught:
            bus.read_byte_data(ADDRESS, 0)
        assert caught.value.errno == ENXIO
        assert bus.read_byte_data(OTHER_ADDRESS, 0) != 0
        time.sleep(RANGING_S)
        assert bus.read_byte_data(ADDRESS, 0) != 0


def test_our_port_gives_the_errno_of_a_missing_acknowledge(adapter: Path) -> None:
    absent = I2cTransfer((I2cMessage(0x22, write=b"\x00"),))
    with closing(open_port("i2c", str(adapter))) as port:
        port.write([absent])
        (result,) = port.read(1.0)
    assert result.errno == ENXIO
    assert result.errno in NACK_ERRNOS


def test_the_time_of_a_transfer_is_measured(adapter: Path, measure: Measure) -> None:
    spans_ms = []
    with SMBus(str(adapter)) as bus:
        for _ in range(100):
            begun = time.perf_counter()
            bus.read_byte_data(ADDRESS, 0)
            spans_ms.append((time.perf_counter() - begun) * 1e3)
    measure(f"I2C byte read: median {median(spans_ms):.1f} ms, longest {max(spans_ms):.1f} ms")
    assert median(spans_ms) < 50.0
