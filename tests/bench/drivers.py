"""A frame, a line, a transfer: through the driver, and by the plainest code that could do it."""

import os
import pty
import tty
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from functools import partial
from random import Random

import can
from smbus2 import i2c_msg
from tests.bench.stopwatch import Row, least_us

from echogrid.drivers import registry
from echogrid.drivers.bus import I2cResult, I2cTransfer
from echogrid.drivers.device import Step
from echogrid.drivers.readings import Outcome, RangeReading
from echogrid.drivers.role import RangerRole
from echogrid.drivers.srf08 import Srf08
from echogrid.drivers.transports.can import CanPort
from echogrid.drivers.transports.i2c import I2cPort
from echogrid.emulation.buses.serial_line import SerialLine
from echogrid.emulation.devices.serial_device import SerialDevice
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.models import RANGERS
from echogrid.emulation.scene import Echo

MS = 1_000_000
ROLE = RangerRole("bench", 0.05, 3.0, None, 343.2)
FRAMES = 5_000
PINGS = 2_000
SLCAN_LINE = b"t0098CDCCCC3D0000803F\r"
SLCAN_FRAMES = 2_000
REGISTERS = b"\x0a\x00\x27\x10"
"""Revision, light, and an echo after 10 ms."""


def rows() -> Iterator[Row]:
    """What is measured."""
    frame, line = bytes.fromhex("FF07A1A7"), b"R1953\r"
    yield Row(
        "a serial frame FF H L SUM, to a reading",
        least_us(streamed("a02yyuw", frame)),
        "the reading and the step made, nothing else",
        least_us(lambda: steps_alone(frame)),
    )
    yield Row(
        "a MaxBotix line, to a reading",
        least_us(streamed("maxbotix", line)),
        "the reading and the step made, nothing else",
        least_us(lambda: steps_alone(line)),
    )
    yield Row(
        "an I2C transfer with its driver and port, the kernel's part left out",
        least_us(i2c_pings),
        "its messages made by smbus2 alone",
        least_us(i2c_messages),
    )
    yield Row("a request on a shared serial line, with its reply and driver", least_us(serial_pings("urm37")))
    yield Row("the same with Modbus RTU", least_us(serial_pings("urm15")))
    for portion, how in ((100, "a hundred at a time"), (1, "one at a time")):
        yield Row(
            f"a CAN frame by slcan through a pty, {how}",
            least_us(partial(slcan_frames, portion)),
            "the same bytes by python-can's slcan",
            least_us(partial(python_can_frames, portion)),
        )


def streamed(driver: str, frame: bytes) -> Callable[[], int]:
    """A ranger that hears one frame after the other."""

    def work() -> int:
        made = registry.driver(driver)
        device = made(ROLE, made.Settings())
        device.step(0, [frame])
        chunk = [frame]
        readings = sum(len(device.step(n * 100 * MS, chunk).readings) for n in range(1, FRAMES + 1))
        assert readings == FRAMES
        return FRAMES

    return work


def steps_alone(raw: bytes) -> int:
    """What no driver can do without: the reading, and the step that brings it."""
    for number in range(FRAMES):
        Step((RangeReading(number, 1, "bench", Outcome.ECHO, 1.953, raw),))
    return FRAMES


class Quick:
    """An adapter that costs nothing: an SRF08 which always hears 10 ms."""

    def open(self) -> None:
        pass

    def close(self) -> None:
        pass

    def transfer(self, transfer: I2cTransfer) -> bytes:
        return REGISTERS[: transfer.messages[0].read]


def i2c_pings() -> int:
    """Pings of an SRF08, each of three transfers. A transfer takes 0.2 ms of the jumping time."""
    port = I2cPort(Quick())
    device = Srf08(ROLE, Srf08.Settings())
    now_ns = transfers = readings = 0
    received: tuple[I2cResult, ...] = ()
    while readings < PINGS:
        step = device.step(now_ns, received)
        readings += len(step.readings)
        port.write(step.send)
        started_ns, now_ns = now_ns, now_ns + 200_000 * len(step.send)
        received = tuple(
            I2cResult(done.transfer, started_ns, now_ns, done.data)
            for done in (port.read(0.0) if step.send else ())
        )
        transfers += len(received)
        now_ns = now_ns if received else max(now_ns, step.deadline_ns)
    return transfers


def i2c_messages() -> int:
    """The same messages as the kernel is given them."""
    for _ in range(PINGS):
        i2c_msg.write(0x70, (0, 0x52))
        i2c_msg.write(0x70, (0,))
        bytes(i2c_msg.read(0x70, 4))
    return 3 * PINGS


def serial_pings(driver: str) -> Callable[[], int]:
    """Requests of one device, each answered at once: as its emulator did when it was first asked."""
    replies: dict[bytes, bytes] = {}
    made = registry.driver(driver)

    def work() -> int:
        line = made.line("bench", [made(ROLE, made.Settings())])
        now_ns = requests = 0
        while requests < PINGS:
            step = line.step(now_ns, ())
            while step.send:
                request = b"".join(item for item in step.send if isinstance(item, bytes))
                if request not in replies:
                    replies[request] = emulated_reply(driver, request)
                requests += 1
                now_ns += 5 * MS
                step = line.step(now_ns, [replies[request]])
            now_ns = max(now_ns + MS, min(step.deadline_ns, now_ns + 100 * MS))
        return requests

    work()
    return work


@contextmanager
def adapter() -> Iterator[tuple[int, str]]:
    """An slcan adapter's end of a pty, and the path of the other."""
    master, slave = pty.openpty()
    tty.setraw(slave)
    try:
        yield master, os.ttyname(slave)
    finally:
        os.close(slave)
        os.close(master)


def slcan_frames(portion: int) -> int:
    """Frames by our port, so many at a time."""
    with adapter() as (master, path), closing(CanPort(path, interface="slcan")) as port:
        port.open()
        for _ in range(SLCAN_FRAMES // portion):
            os.write(master, SLCAN_LINE * portion)
            left = portion
            while left:
                left -= len(port.read(1.0))
    return SLCAN_FRAMES


def python_can_frames(portion: int) -> int:
    """The same by python-can."""
    options = {"bitrate": 250_000, "sleep_after_open": 0, "timeout": 0, "ignore_config": True}
    with adapter() as (master, path), can.Bus(path, "slcan", **options) as bus:
        for _ in range(SLCAN_FRAMES // portion):
            os.write(master, SLCAN_LINE * portion)
            left = portion
            while left:
                left -= bus.recv(0.0) is not None
    return SLCAN_FRAMES


def emulated_reply(driver: str, request: bytes) -> bytes:
    """What the emulated device before a wall answers."""
    wall = Surroundings(lambda fire_ns: (Echo(1.0, 60.0, "wall"),), 343.2)
    device = RANGERS[driver].build(driver, wall, Random(1), {})
    assert isinstance(device, SerialDevice)
    line = SerialLine("line", device)
    line.switch_on(0)
    line.advance(2_000 * MS)
    line.take(2_000 * MS)
    line.send((request,), 2_000 * MS)
    return b"".join(line.take(3_000 * MS))
