"""USB devices, asked as the kernel's drivers ask them, at the other end of the USB/IP link."""

import select
import socket
import struct
from collections.abc import Iterator
from errno import ENXIO
from random import Random

from pytest import approx, fixture, mark, raises
from pytest_mock import MockerFixture

from echogrid.drivers.bus import CanFrame
from echogrid.drivers.clock import JumpingClock
from echogrid.emulation.buses.i2c_bus import I2cBus
from echogrid.emulation.buses.serial_line import SerialLine
from echogrid.emulation.devices.a02yyuw import A02yyuwSensor
from echogrid.emulation.devices.srf08 import Srf08Chip
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.scene import Echo
from echogrid.emulation.wires import vcan
from echogrid.emulation.wires.loop import Loop
from echogrid.emulation.wires.usb_i2c import UsbI2cWire
from echogrid.emulation.wires.usb_serial import UsbSerialWire
from echogrid.emulation.wires.usbip import UsbIpError
from echogrid.emulation.wires.wire import Wire

MS = 1_000_000
HEADER = 48
STALL, WITHDRAWN = -32, -104
IN, OUT = 1, 0
VENDOR_IN, VENDOR_OUT = 0xC0, 0x40
I2C_READ, I2C_WRITE, I2C_STATUS = 7, 7, 3
DIVISOR_9600, DIVISOR_115200 = 0x4138, 0x001A
WALL = Surroundings(lambda fire_ns: (Echo(1.0, 40.0, "wall"),), 343.0)


class Kernel:
    """The kernel's end of the cable, and the clock and loop that the device lives by."""

    def __init__(self) -> None:
        self.clock = JumpingClock(MS)
        self.loop = Loop()
        self.plugged: list[socket.socket] = []
        self.wire: Wire[bytes, bytes] | UsbI2cWire
        self._sequence = 0

    def attach(self, end: socket.socket) -> None:
        self.plugged.append(end.dup())

    def submit(
        self, endpoint: int, direction: int, data: bytes = b"", length: int = 0, setup: bytes = b""
    ) -> int:
        """Ask, and let the device take it; the number of the request."""
        self._sequence += 1
        size = length if direction == IN else len(data)
        head = struct.pack(">IIIIIIi12x", 1, self._sequence, 0, direction, endpoint, 0, size)
        self.plugged[-1].send(head + setup.ljust(8, b"\0") + data)
        self.turn()
        return self._sequence

    def control(
        self, kind: int, request: int, value: int = 0, index: int = 0, data: bytes = b"", length: int = 0
    ) -> int:
        setup = struct.pack("<BBHHH", kind, request, value, index, max(length, len(data)))
        return self.submit(0, IN if kind & 0x80 else OUT, data, length, setup)

    def withdraw(self, sequence: int) -> int:
        """The status that the device answers with."""
        self._sequence += 1
        self.plugged[-1].send(struct.pack(">IIIIII24x", 2, self._sequence, 0, 0, 0, sequence))
        self.turn()
        return int(struct.unpack_from(">i", self.plugged[-1].recv(HEADER), 20)[0])

    def answer(self) -> tuple[int, int, bytes]:
        """The number, status and data of the next request that is done."""
        head = self.plugged[-1].recv(HEADER, socket.MSG_DONTWAIT)
        sequence, status, length = *struct.unpack_from(">I", head, 4), *struct.unpack_from(">ii", head, 20)
        data = self.plugged[-1].recv(length, socket.MSG_DONTWAIT) if length and not self.silent() else b""
        return sequence, status, data

    def silent(self) -> bool:
        """Whether the device has nothing to say."""
        return not select.select([self.plugged[-1]], [], [], 0.0)[0]

    def turn(self, for_ns: int = 0) -> None:
        self.loop.wait(0.0)
        self.clock.sleep_until_ns(self.clock.now_ns() + for_ns)
        self.wire.pump()


@fixture
def kernel(mocker: MockerFixture) -> Iterator[Kernel]:
    kernel = Kernel()
    mocker.patch("echogrid.emulation.wires.usbip._attach", side_effect=kernel.attach)
    yield kernel
    kernel.wire.close()
    for end in kernel.plugged:
        end.close()
    kernel.loop.close()


@fixture
def ring(kernel: Kernel) -> I2cBus:
    """A bus with a ranger at 0x70, plugged in."""
    bus = I2cBus("ring", 100_000, [Srf08Chip("front", WALL, Random(1))])
    bus.switch_on(kernel.clock.now_ns())
    kernel.wire = UsbI2cWire(bus, "ring", kernel.clock, kernel.loop)
    kernel.wire.pump()
    return bus


@fixture
def line(kernel: Kernel) -> SerialLine:
    """A line with a ranger, plugged in."""
    line = SerialLine("line", A02yyuwSensor("front", WALL, Random(1)))
    line.switch_on(kernel.clock.now_ns())
    kernel.wire = UsbSerialWire(line, "left", kernel.clock, kernel.loop, Random(1))
    kernel.wire.pump()
    return line


def test_the_device_says_who_it_is(kernel: Kernel, ring: I2cBus) -> None:
    kernel.control(0x80, 6, 0x0100, length=18)
    device = kernel.answer()[2]
    assert struct.unpack_from("<BBHBBBBHHH", device) == (18, 1, 0x0110, 0, 0, 0, 64, 0x0403, 0xC631, 0x0205)
    serials_index = device[16]
    kernel.control(0x80, 6, 0x0300 | serials_index, length=255)
    assert kernel.answer()[2][2:].decode("utf-16-le") == "ring"


def test_a_configuration_counts_its_own_bytes_and_endpoints(kernel: Kernel, line: SerialLine) -> None:
    kernel.control(0x80, 6, 0x0200, length=255)
    configuration = kernel.answer()[2]
    assert struct.unpack_from("<H", configuration, 2) == (len(configuration),)
    assert configuration[9 + 4] == 2
    assert (configuration[18 + 2], configuration[25 + 2]) == (0x81, 0x02)


@mark.parametrize("value", [0x0600, 0x0309])
def test_an_unknown_descriptor_is_refused(kernel: Kernel, ring: I2cBus, value: int) -> None:
    kernel.control(0x80, 6, value, length=10)
    assert kernel.answer()[1] == STALL


def test_a_register_is_read_when_the_bus_has_carried_it(kernel: Kernel, ring: I2cBus) -> None:
    kernel.control(VENDOR_OUT, I2C_WRITE, 0, 0x70, data=b"\x00")
    assert kernel.silent()
    kernel.turn(MS)
    assert kernel.answer()[1] == 0
    kernel.control(VENDOR_IN, I2C_READ, 1, 0x70, length=1)
    kernel.turn(MS)
    assert kernel.answer()[2] == bytes((10,))
    kernel.control(VENDOR_IN, I2C_STATUS, length=1)
    assert kernel.answer()[2] == b"\x01"


def test_a_missing_acknowledge_is_the_adapters_status(kernel: Kernel, ring: I2cBus) -> None:
    kernel.control(VENDOR_IN, I2C_READ, 1, 0x22, length=2)
    kernel.turn(MS)
    assert kernel.answer()[1:] == (0, b"\xff\xff")
    kernel.control(VENDOR_IN, I2C_STATUS, length=1)
    assert kernel.answer()[2] == b"\x02"
    assert ENXIO == 6


def test_a_withdrawn_transfer_is_not_answered(kernel: Kernel, ring: I2cBus) -> None:
    sequence = kernel.control(VENDOR_IN, I2C_READ, 1, 0x70, length=1)
    assert kernel.withdraw(sequence) == WITHDRAWN
    kernel.turn(MS)
    assert kernel.silent()
    assert kernel.withdraw(sequence) == 0


def test_an_unplug_ends_the_link_and_a_plug_makes_another(kernel: Kernel, ring: I2cBus) -> None:
    ring.fault("unplug", kernel.clock.now_ns())
    kernel.turn()
    assert kernel.plugged[0].recv(1) == b""
    ring.clear(kernel.clock.now_ns())
    kernel.turn()
    assert len(kernel.plugged) == 2


def test_a_kernel_that_lets_go_is_survived(kernel: Kernel, ring: I2cBus) -> None:
    kernel.plugged[0].shutdown(socket.SHUT_RDWR)
    kernel.turn()
    kernel.turn(MS)
    kernel.wire.close()


def test_a_frame_comes_at_the_right_speed(kernel: Kernel, line: SerialLine) -> None:
    kernel.control(VENDOR_OUT, 3, DIVISOR_9600)
    assert kernel.answer()[1] == 0
    kernel.submit(1, IN, length=512)
    kernel.turn(400 * MS)
    _, status, data = kernel.answer()
    assert (status, data[:2]) == (0, b"\x01\x60")
    assert data[2:6] == bytes.fromhex("FF03E8EA")


def test_at_a_wrong_speed_both_sides_read_garbage(kernel: Kernel, line: SerialLine) -> None:
    kernel.control(VENDOR_OUT, 3, DIVISOR_115200)
    kernel.answer()
    kernel.submit(1, IN, length=512)
    kernel.turn(400 * MS)
    assert kernel.answer()[2][2:6] not in (b"", bytes.fromhex("FF03E8EA"))


@mark.parametrize(
    ("value", "index", "baud"),
    [
        (0x4138, 0, 9600),
        (0x001A, 0, 115_200),
        (0x2710, 0, 300),
        (0xC068, 0, 28_800),
        (1, 0, 2e6),
        (0, 0, 3e6),
    ],
)
def test_the_speed_is_that_of_the_divisor(
    kernel: Kernel, line: SerialLine, value: int, index: int, baud: float
) -> None:
    kernel.control(VENDOR_OUT, 3, value, index)
    assert isinstance(kernel.wire, UsbSerialWire)
    assert kernel.wire.baud == approx(baud, rel=0.005)


def test_bytes_wait_for_a_reader_and_the_oldest_are_kept(kernel: Kernel, line: SerialLine) -> None:
    kernel.control(VENDOR_OUT, 3, DIVISOR_9600)
    kernel.answer()
    for _ in range(100):
        kernel.turn(100 * MS)
    received = 0
    for _ in range(10):
        kernel.submit(1, IN, length=64)
        received += 0 if kernel.silent() else len(kernel.answer()[2]) - 2
    assert received == 256


def test_without_vhci_it_says_what_to_do(kernel: Kernel, mocker: MockerFixture) -> None:
    mocker.patch("echogrid.emulation.wires.usbip._attach", side_effect=FileNotFoundError("status"))
    kernel.wire = UsbI2cWire(I2cBus("ring", 100_000, []), "ring", kernel.clock, kernel.loop)
    with raises(UsbIpError, match="modprobe vhci-hcd"):
        kernel.wire.pump()


GOLDEN = [
    (CanFrame(0x001, b"\xaa\xbb"), "01000000 02000000 AABB000000000000"),
    (CanFrame(0x981, bytes(8), extended=True), "81090080 08000000 0000000000000000"),
    (CanFrame(0x069, b"", remote=True), "69000040 00000000 0000000000000000"),
]


@mark.parametrize(("frame", "packet"), GOLDEN)
def test_a_frame_is_the_kernels(frame: CanFrame, packet: str) -> None:
    packed = bytes.fromhex(packet.replace(" ", ""))
    assert vcan.encode(frame) == packed
    assert vcan.decode(packed) == frame
