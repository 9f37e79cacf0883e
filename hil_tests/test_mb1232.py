"""The emulated I2CXL-MaxSonar behind the kernel's own I2C adapter, judged by the kernel's driver mb1232.

Without a wire for the part's status pin that driver reads 15 ms after the command, when a real part still
ranges and does not acknowledge. So the chip as it is must give it errors, and one that is done in 10 ms
the distance.
"""

from collections.abc import Iterator
from contextlib import closing
from errno import ENXIO
from pathlib import Path
from random import Random

from pytest import approx, fixture, mark, raises
from smbus2 import SMBus

from echogrid.drivers.i2cxl import I2cxl, address_change
from echogrid.drivers.readings import Outcome
from echogrid.drivers.role import RangerRole
from echogrid.drivers.transports.ports import open_port
from echogrid.emulation.devices.i2cxl import I2cxlChip, I2cxlOptions
from hil_tests.conftest import Measure
from hil_tests.kernel import node_of, wait_for
from hil_tests.kernel_devices import SPEED_OF_SOUND, KernelDevices, Wall
from hil_tests.pumping import Readout

FAITHFUL, QUICK, SPARE = 0x70, 0x71, 0x72
MOVED = 0x73
QUICK_NS = 10_000_000
"""Sound goes 1.7 m and back in that time."""
OWN_SPEED = 344.8
ATTEMPTS = 5
CENTIMETRE = 0.01

pytestmark = mark.usefixtures("guest")


@fixture(scope="module")
def wall() -> Wall:
    return Wall(1.0)


@fixture(scope="module")
def adapter(devices: KernelDevices, wall: Wall) -> Path:
    """The kernel's node for an adapter with three parts: as they are, quick, and to be moved."""
    options = (I2cxlOptions(FAITHFUL), I2cxlOptions(QUICK, ranging_ns=QUICK_NS), I2cxlOptions(SPARE))
    chips = [
        I2cxlChip(f"i2cxl {each.address:#x}", wall.surroundings(), Random(each.address), each)
        for each in options
    ]
    devices.i2c_chips("maxbotix", chips)
    return node_of("i2c-dev", "maxbotix")


@fixture
def faithful(adapter: Path) -> Iterator[Path]:
    yield from bound(adapter, FAITHFUL)


@fixture
def quick(adapter: Path) -> Iterator[Path]:
    yield from bound(adapter, QUICK)


def bound(adapter: Path, address: int) -> Iterator[Path]:
    """The folder of the kernel's own driver, bound to the part at that address."""
    bus = Path("/sys/bus/i2c/devices") / adapter.name
    (bus / "new_device").write_text(f"maxbotix-mb1232 {address:#x}")
    client = bus / f"{adapter.name.removeprefix('i2c-')}-00{address:x}"
    yield wait_for("IIO device", lambda: list(client.glob("iio:device*")))[0]
    (bus / "delete_device").write_text(f"{address:#x}")


def read_by_iio(folder: Path) -> float | OSError:
    """m; or the kernel's error."""
    try:
        raw, scale = ((folder / f"in_distance_{name}").read_text() for name in ("raw", "scale"))
    except OSError as error:
        return error
    return int(raw) * float(scale)


@mark.parametrize("distance", [0.25, 0.77, 1.50])
def test_a_quick_part_is_read_right_by_the_kernels_own_driver(
    quick: Path, wall: Wall, distance: float, measure: Measure
) -> None:
    wall.distance = distance
    read = read_by_iio(quick)
    measure(f"IIO mb1232: {distance:.2f} m read as {read} m")
    assert read == approx(distance * OWN_SPEED / SPEED_OF_SOUND, abs=CENTIMETRE)


def test_a_part_as_it_is_gives_that_driver_errors_and_no_wrong_distance(
    faithful: Path, wall: Wall, measure: Measure
) -> None:
    wall.distance = 1.50
    reads = [read_by_iio(faithful) for _ in range(ATTEMPTS)]
    errors = [read for read in reads if isinstance(read, OSError)]
    distances = [read for read in reads if not isinstance(read, OSError)]
    measure(f"IIO mb1232, a part that ranges for 65 ms: {len(errors)} of {ATTEMPTS} readings are errors")
    assert errors
    assert {error.errno for error in errors} == {ENXIO}
    assert distances == [approx(1.50 * OWN_SPEED / SPEED_OF_SOUND, abs=CENTIMETRE)] * len(distances)


@mark.parametrize("distance", [0.25, 1.50, 5.50])
def test_our_driver_reads_a_part_as_it_is(
    adapter: Path, wall: Wall, distance: float, measure: Measure
) -> None:
    wall.distance = distance
    device = I2cxl(RangerRole("i2cxl", 0.03, 7.0, None, SPEED_OF_SOUND), I2cxl.Settings(FAITHFUL))
    with closing(open_port("i2c", str(adapter))) as port:
        reading = Readout(port, device).ranges(1)[0]
    measure(f"our driver, I2CXL: {distance:.2f} m read as {reading.distance:.4f} m")
    assert reading.outcome is Outcome.ECHO
    assert reading.distance == approx(distance, abs=CENTIMETRE)


def test_a_part_moves_to_another_address(adapter: Path) -> None:
    with SMBus(str(adapter)) as bus:
        keys, *rest = address_change(MOVED)
        bus.write_i2c_block_data(SPARE, keys, rest)
        bus.read_byte(MOVED)
        with raises(OSError) as caught:
            bus.read_byte(SPARE)
    assert caught.value.errno == ENXIO
