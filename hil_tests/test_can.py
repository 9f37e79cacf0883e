"""CAN frames on the kernel's own bus, judged by can-utils."""

import socket
import struct
import subprocess
import time
from collections.abc import Iterator
from contextlib import closing

from pytest import approx, fixture, mark
from tests.drivers.candump import logged

from echogrid.drivers.bus import CanFrame
from echogrid.drivers.readings import WheelReading
from echogrid.drivers.transports.can import CanPort
from echogrid.mapping.kinematics import Differential
from echogrid.mapping.odometry import Odometry
from hil_tests.conftest import Measure
from hil_tests.kernel import add_vcan, command
from hil_tests.kernel_devices import KernelDevices
from hil_tests.pumping import Readout, odrive

EMULATED, QUIET = "vcan0", "vcan1"
FRAME = struct.Struct("=IB3x8s")
DUMP = 60
"""How many frames candump shows."""
MILLISECOND_NS = 1_000_000

pytestmark = mark.usefixtures("guest")


@fixture(scope="module")
def wheels(devices: KernelDevices) -> None:
    """Two axes that turn."""
    add_vcan(EMULATED)
    devices.can(EMULATED, {0: 3.0, 1: -2.0})


@fixture(scope="module", autouse=True)
def quiet_bus(guest: None) -> None:
    """A bus on which only the tests send."""
    add_vcan(QUIET)


@fixture
def port() -> Iterator[CanPort]:
    with closing(CanPort(QUIET)) as port:
        port.open()
        yield port


def monotonic_of(wall_ns: int) -> int:
    return wall_ns - time.time_ns() + time.monotonic_ns()


def test_candump_shows_the_frames_that_the_driver_reads(wheels: None, measure: Measure) -> None:
    frames: list[CanFrame] = []
    with closing(CanPort(EMULATED)) as port:
        port.open()
        dump = subprocess.Popen(
            ["candump", "-L", "-n", str(DUMP), EMULATED], stdout=subprocess.PIPE, text=True
        )
        while dump.poll() is None:
            frames += port.read(0.1)
        frames += port.read(0.1)
    shown = logged(dump.communicate()[0])
    ours = [(frame.identifier, frame.data) for frame in frames]
    theirs = [(frame.identifier, frame.data) for frame in shown]
    begins = [at for at in range(len(ours)) if ours[at : at + len(theirs)] == theirs]
    assert (len(theirs), len(begins)) == (DUMP, 1)
    apart_ns = [
        abs(frame.stamp_ns - monotonic_of(other.stamp_ns))
        for frame, other in zip(frames[begins[0] :], shown, strict=False)
    ]
    measure(f"stamps of {len(theirs)} frames differ from candump's by at most {max(apart_ns) / 1e3:.0f} us")
    assert max(apart_ns) < MILLISECOND_NS


def test_the_driver_reads_turning_wheels(wheels: None) -> None:
    with closing(CanPort(EMULATED)) as port:
        port.open()
        readings = Readout(port, odrive("left", 0), odrive("right", 1)).take(40)
    rates = {reading.wheel: reading.rate for reading in readings if isinstance(reading, WheelReading)}
    assert rates == {"left": approx(3.0, abs=0.3), "right": approx(-2.0, abs=0.3)}


def test_cansend_moves_the_odometry(port: CanPort) -> None:
    left, right = odrive("left", 0), odrive("right", 1)
    readout = Readout(port, left, right)
    readout.pump.turn()
    odometry = Odometry(Differential(0.1, 0.1, 0.4, 1e-4))
    for stamp_ns, turns in enumerate((0.0, 0.5)):
        position = struct.pack("<ff", turns, 0.5).hex()
        for node in (0x00, 0x20):
            command("cansend", QUIET, f"{node | 0x001:03X}#0000000001000000")
            command("cansend", QUIET, f"{node | 0x009:03X}#{position}")
        latest = {
            reading.wheel: reading.angle for reading in readout.take(2) if isinstance(reading, WheelReading)
        }
        pose = odometry.update(stamp_ns, (latest["left"], latest["right"]))
    assert pose.x == approx(0.1 * 3.14159, abs=1e-4)
    assert pose.y == approx(0.0, abs=1e-6)


def test_a_frame_read_late_bears_the_time_when_it_came(port: CanPort, measure: Measure) -> None:
    with socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as sender:
        sender.bind((QUIET,))
        before_ns = time.monotonic_ns()
        sender.send(FRAME.pack(0x021, 8, bytes(8)))
        after_ns = time.monotonic_ns()
    time.sleep(0.2)
    (frame,) = port.read(1.0)
    measure(
        f"a frame sent within {(after_ns - before_ns) / 1e3:.0f} us and read 200 ms later is stamped "
        f"{(frame.stamp_ns - before_ns) / 1e3:.0f} us after the call began"
    )
    assert before_ns - MILLISECOND_NS <= frame.stamp_ns <= after_ns + MILLISECOND_NS


def test_a_stamp_survives_a_step_of_the_wall_clock(port: CanPort) -> None:
    with socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as sender:
        sender.bind((QUIET,))
        sender.send(FRAME.pack(0x021, 8, bytes(8)))
        port.read(1.0)
        time.clock_settime(time.CLOCK_REALTIME, time.time() + 3600.0)
        before_ns = time.monotonic_ns()
        sender.send(FRAME.pack(0x021, 8, bytes(8)))
        after_ns = time.monotonic_ns()
        (frame,) = port.read(1.0)
        time.clock_settime(time.CLOCK_REALTIME, time.time() - 3600.0)
    assert before_ns - MILLISECOND_NS <= frame.stamp_ns <= after_ns + MILLISECOND_NS
