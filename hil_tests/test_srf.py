"""Emulated Devantech rangers behind the kernel's own I2C adapter, judged by the kernel's driver for them.

Of an SRF02 that driver believes that it ranges within a few milliseconds, and gives up before the 65 that a
real one takes. So the chip as it is must give it EIO, and one that has done in 20 ms the distance.
"""

import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from errno import EINVAL, EIO, ENXIO
from pathlib import Path
from random import Random

from pytest import approx, fixture, mark, raises
from smbus2 import SMBus

from echogrid.drivers.devantech import address_change
from echogrid.drivers.readings import Outcome
from echogrid.drivers.role import RangerRole
from echogrid.drivers.srf02 import Srf02
from echogrid.drivers.srf08 import Srf08
from echogrid.drivers.srf10 import Srf10
from echogrid.drivers.transports.ports import open_port
from echogrid.emulation.devices.srf02 import Srf02Chip, Srf02Options
from echogrid.emulation.devices.srf08 import Srf08Chip, Srf08Options
from echogrid.emulation.devices.srf10 import Srf10Chip, Srf10Options
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.scene import Echo
from hil_tests.conftest import Measure
from hil_tests.kernel import node_of, wait_for
from hil_tests.kernel_devices import SPEED_OF_SOUND, KernelDevices
from hil_tests.pumping import Readout

FAITHFUL, QUICK, EIGHT, TEN, SPARE, MOVED = range(0x70, 0x76)
QUICK_NS = 20_000_000
"""Sound goes 3.4 m and back in that time."""
RANGING_S = 0.065
RANGING_NS = 65_000_000
ATTEMPTS = 5
CENTIMETRE = 0.01
LOUD, FAINT = 60.0, 10.0
"""dB over the threshold at the highest gain."""

ROLE = RangerRole("ranger", 0.06, 6.0, None, SPEED_OF_SOUND)
DRIVERS: dict[str, Callable[[], Srf02 | Srf08 | Srf10]] = {
    "srf02": lambda: Srf02(ROLE, Srf02.Settings(FAITHFUL)),
    "srf08": lambda: Srf08(ROLE, Srf08.Settings(EIGHT)),
    "srf10": lambda: Srf10(ROLE, Srf10.Settings(TEN)),
}

pytestmark = mark.usefixtures("guest")


@dataclass(slots=True)
class Wall:
    """All that the rangers hear."""

    distance: float = 1.0
    """m."""
    margin: float = LOUD

    def __call__(self, fire_ns: int) -> tuple[Echo, ...]:
        return (Echo(self.distance, self.margin, "wall"),)


class WatchedSrf02(Srf02Chip):
    """Notes when it was last told to range, and when it was last asked for the range."""

    told_ns = asked_ns = 0

    def write(self, data: bytes, now_ns: int) -> None:
        if data[:1] == b"\x02":
            self.asked_ns = now_ns
        elif len(data) > 1:
            self.told_ns = now_ns
        super().write(data, now_ns)


@fixture(scope="module")
def shared_wall() -> Wall:
    return Wall()


@fixture(scope="module")
def faithful(shared_wall: Wall) -> WatchedSrf02:
    """An SRF02 that ranges for as long as a real one."""
    room = Surroundings(shared_wall, SPEED_OF_SOUND)
    return WatchedSrf02("srf02", room, Random(1), Srf02Options(FAITHFUL))


@fixture
def wall(shared_wall: Wall) -> Wall:
    shared_wall.distance, shared_wall.margin = 1.0, LOUD
    return shared_wall


@fixture(scope="module")
def adapter(devices: KernelDevices, shared_wall: Wall, faithful: WatchedSrf02) -> Path:
    """The kernel's node for an adapter with one of each, a quick SRF02, and one to be moved."""
    room = Surroundings(shared_wall, SPEED_OF_SOUND)
    chips = (
        faithful,
        Srf02Chip("quick", room, Random(2), Srf02Options(QUICK, ranging_ns=QUICK_NS)),
        Srf08Chip("srf08", room, Random(3), Srf08Options(EIGHT)),
        Srf10Chip("srf10", room, Random(4), Srf10Options(TEN)),
        Srf10Chip("spare", room, Random(5), Srf10Options(SPARE)),
    )
    devices.i2c_chips("devantech", chips)
    return node_of("i2c-dev", "devantech")


@contextmanager
def bound(adapter: Path, kind: str, address: int) -> Iterator[Path]:
    """The folder of the kernel's own driver, bound to the chip at that address as one of that kind."""
    bus = Path("/sys/bus/i2c/devices") / adapter.name
    (bus / "new_device").write_text(f"{kind} {address:#x}")
    client = bus / f"{adapter.name.removeprefix('i2c-')}-00{address:x}"
    try:
        yield wait_for("IIO device", lambda: list(client.glob("iio:device*")))[0]
    finally:
        (bus / "delete_device").write_text(f"{address:#x}")


def read_by_iio(folder: Path) -> float:
    """m."""
    raw, scale = ((folder / f"in_distance_{name}").read_text() for name in ("raw", "scale"))
    return int(raw) * float(scale)


@mark.parametrize(
    ("kind", "address", "distance"),
    [
        *(("srf02", QUICK, distance) for distance in (0.35, 1.50, 3.00)),
        *(("srf08", EIGHT, distance) for distance in (0.05, 1.50, 5.50)),
        *(("srf10", TEN, distance) for distance in (0.07, 1.50, 5.50)),
    ],
)
def test_the_kernels_own_driver_reads_each_chip_right(
    adapter: Path, wall: Wall, kind: str, address: int, distance: float, measure: Measure
) -> None:
    wall.distance = distance
    with bound(adapter, kind, address) as folder:
        read = read_by_iio(folder)
    measure(f"IIO {kind}: {distance:.2f} m read as {read:.2f} m")
    assert read == approx(distance, abs=CENTIMETRE)


def test_an_srf02_as_it_is_gives_that_driver_eio_and_no_wrong_distance(
    adapter: Path, faithful: WatchedSrf02, wall: Wall, measure: Measure
) -> None:
    wall.distance = 1.50
    errors: list[OSError] = []
    with bound(adapter, "srf02", FAITHFUL) as folder:
        for _ in range(ATTEMPTS):
            try:
                read = read_by_iio(folder)
            except OSError as error:
                errors.append(error)
            else:
                assert read == approx(1.50, abs=CENTIMETRE)
                assert faithful.asked_ns - faithful.told_ns > RANGING_NS
            time.sleep(2 * RANGING_S)
    measure(f"IIO srf02, a chip that ranges for 65 ms: {len(errors)} of {ATTEMPTS} readings are EIO")
    assert errors
    assert {error.errno for error in errors} == {EIO}


@mark.parametrize(("kind", "address"), [("srf08", EIGHT), ("srf10", TEN)])
def test_the_range_that_the_kernel_sets_is_the_chips(
    adapter: Path, wall: Wall, kind: str, address: int
) -> None:
    with bound(adapter, kind, address) as folder:
        reach = folder / "sensor_max_range"
        assert reach.read_text() == "6.020\n"
        reach.write_text("2.021")
        assert reach.read_text() == "2.021\n"
        for distance, read in ((1.98, 1.98), (2.05, 0.0)):
            wall.distance = distance
            assert read_by_iio(folder) == approx(read, abs=CENTIMETRE)
        with raises(OSError) as caught:
            reach.write_text("2.000")
        assert caught.value.errno == EINVAL


@mark.parametrize(
    ("kind", "address", "gains"), [("srf08", EIGHT, Srf08Chip.gains), ("srf10", TEN, Srf10Chip.gains)]
)
def test_the_gains_that_the_kernel_knows_are_the_chips(
    adapter: Path, wall: Wall, kind: str, address: int, gains: tuple[int, ...]
) -> None:
    wall.margin = FAINT
    with bound(adapter, kind, address) as folder:
        available = (folder / "sensor_sensitivity_available").read_text()
        assert tuple(map(int, available.split())) == gains
        sensitivity = folder / "sensor_sensitivity"
        assert sensitivity.read_text() == f"{gains[-1]}\n"
        assert read_by_iio(folder) == approx(1.0, abs=CENTIMETRE)
        sensitivity.write_text(str(gains[0]))
        assert read_by_iio(folder) == 0.0


@mark.parametrize("distance", [0.35, 1.50, 5.50])
@mark.parametrize("name", DRIVERS)
def test_our_drivers_read_each_chip_right(
    adapter: Path, wall: Wall, name: str, distance: float, measure: Measure
) -> None:
    wall.distance = distance
    with closing(open_port("i2c", str(adapter))) as port:
        reading = Readout(port, DRIVERS[name]()).ranges(1)[0]
    measure(f"our {name} driver: {distance:.2f} m read as {reading.distance:.4f} m")
    assert reading.outcome is Outcome.ECHO
    assert reading.distance == approx(distance, abs=0.001)


def test_a_chip_moves_to_another_address(adapter: Path) -> None:
    with SMBus(str(adapter)) as bus:
        for register, value in address_change(MOVED):
            bus.write_byte_data(SPARE, register, value)
        assert bus.read_byte_data(MOVED, 1) == 0x80
        with raises(OSError) as caught:
            bus.read_byte(SPARE)
    assert caught.value.errno == ENXIO
