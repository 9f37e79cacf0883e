"""Our driver of the kernel's rangers, over the kernel's own files, against the truth.

The kernel reads an emulated SRF08 by its own driver; we read the kernel.
"""

import time
from collections.abc import Iterator
from contextlib import closing
from errno import ENODEV
from pathlib import Path

from pytest import approx, fixture, mark

from echogrid.drivers.bus import IioRead
from echogrid.drivers.device import State
from echogrid.drivers.iio import Iio
from echogrid.drivers.readings import Outcome
from echogrid.drivers.role import RangerRole
from echogrid.drivers.transports.ports import open_port
from hil_tests.conftest import Measure
from hil_tests.kernel import node_of, wait_for
from hil_tests.kernel_devices import SPEED_OF_SOUND, KernelDevices, Wall
from hil_tests.pumping import Readout

FOLDER = Path("/sys/bus/iio/devices")
ADDRESS = 0x72
SERIAL = "pins"
DISTANCES = (0.05, 0.77, 1.50, 2.50, 5.50)
NEAR = 0.01
"""m: the kernel tells centimetres."""

pytestmark = mark.usefixtures("guest")


class Client:
    """A chip on an adapter, which the kernel is told of, or told to forget."""

    def __init__(self, adapter: str) -> None:
        self._bus = Path("/sys/bus/i2c/devices") / adapter
        self.name = f"{adapter.removeprefix('i2c-')}-00{ADDRESS:x}"
        """What the kernel calls it: N-00AA."""

    def bind(self) -> str:
        """Its IIO device's folder, iio:deviceN."""
        (self._bus / "new_device").write_text(f"srf08 {ADDRESS:#x}")
        client = self._bus / self.name
        return wait_for("IIO device", lambda: list(client.glob("iio:device*")))[0].name

    def unbind(self) -> None:
        (self._bus / "delete_device").write_text(f"{ADDRESS:#x}")


@fixture(scope="module")
def wall() -> Wall:
    return Wall(1.0)


@fixture(scope="module")
def client(devices: KernelDevices, wall: Wall) -> Client:
    devices.i2c(SERIAL, {ADDRESS: wall})
    return Client(node_of("i2c-dev", SERIAL).name)


@fixture
def folder(client: Client) -> Iterator[str]:
    yield client.bind()
    client.unbind()


def seen_missing(pins: Readout) -> bool:
    """Whether our driver, after a turn, says that the device is missing."""
    pins.pump.turn()
    return pins.pump.line.devices[0].health(time.monotonic_ns()).state is State.MISSING


def readout(device: str) -> Readout:
    """Our driver on the kernel's folder."""
    role = RangerRole("front", 0.03, 6.0, None, SPEED_OF_SOUND)
    return Readout(open_port("iio", str(FOLDER)), Iio(role, Iio.Settings(device=device)))


@mark.parametrize("distance", DISTANCES)
def test_our_driver_of_the_kernels_ranger_agrees_with_the_truth(
    folder: str, wall: Wall, distance: float, measure: Measure
) -> None:
    wall.distance = distance
    with closing(readout(folder)) as pins:
        reading = pins.ranges(1)[0]
    measure(f"IIO by our driver: {distance:.2f} m read as {reading.distance:.4f} m ({reading.raw.decode()})")
    assert reading.outcome is Outcome.ECHO
    assert reading.distance == approx(distance, abs=NEAR)


def test_the_device_is_found_by_its_driver_and_by_what_it_hangs_on(folder: str, client: Client) -> None:
    with closing(open_port("iio", str(FOLDER))) as port:
        for device in (folder, "srf08", client.name):
            port.write([IioRead(device, "in_distance_scale")])
        texts = [result.data for result in port.read(0.0)]
    assert texts == [b"0.010000\n"] * 3


def test_what_is_out_of_reach_is_no_echo(folder: str, wall: Wall) -> None:
    wall.distance = 9.0
    with closing(readout(folder)) as pins:
        assert pins.ranges(1)[0].outcome is Outcome.NO_ECHO


def test_the_time_that_a_ping_holds_its_thread_is_measured(folder: str, wall: Wall, measure: Measure) -> None:
    wall.distance = 1.0
    with closing(open_port("iio", str(FOLDER))) as port:
        port.write([IioRead(folder, "in_distance_raw")])
        (result,) = port.read(0.0)
    lasted_ms = (result.end_ns - result.start_ns) / 1e6
    measure(f"IIO srf08: one read takes {lasted_ms:.0f} ms")
    assert result.errno == 0
    assert 30.0 < lasted_ms < 500.0


def test_a_device_that_leaves_the_kernel_is_missing_and_found_again(client: Client, wall: Wall) -> None:
    wall.distance = 1.0
    client.bind()
    with closing(readout(client.name)) as pins:
        assert pins.ranges(1)[0].outcome is Outcome.ECHO
        client.unbind()
        wait_for("its absence", lambda: seen_missing(pins), poll_s=0.0)
        client.bind()
        found = pins.until(lambda readings: bool(readings), "a reading after its return")
        client.unbind()
    assert getattr(found[-1], "outcome", None) is Outcome.ECHO


def test_a_device_that_is_not_there_is_told_by_errno() -> None:
    with closing(open_port("iio", str(FOLDER))) as port:
        port.write([IioRead("iio:device99", "name")])
        assert port.read(0.0)[0].errno == ENODEV
