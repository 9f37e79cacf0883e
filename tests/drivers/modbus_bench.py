"""A serial line with Modbus slaves that are played by hand."""

from collections.abc import Callable

from umodbus.client.serial.redundancy_check import get_crc

from echogrid.drivers.conversation import Conversation
from echogrid.drivers.device import Device
from echogrid.drivers.readings import RangeReading

MS = 1_000_000
BYTE_NS = 520_833
"""At 19200 baud."""
TURNAROUND_NS = 3 * MS


def sealed(*body: int) -> bytes:
    """A frame, by another library's checksum."""
    return bytes(body) + get_crc(bytes(body))


class Slave:
    """Registers at an address. `reply` may be put in front of what it would say."""

    def __init__(self, address: int, registers: dict[int, int]) -> None:
        self.address = address
        self.registers = registers
        self.written: list[tuple[int, int]] = []
        self.spoilt: Callable[[bytes], bytes] = lambda frame: frame

    def answer(self, request: bytes) -> bytes:
        """The reply to a request for it; nothing to one for others."""
        address, function = request[:2]
        if address != self.address or sealed(*request[:-2]) != request:
            return b""
        register, word = (int.from_bytes(request[at : at + 2], "big") for at in (2, 4))
        if function == 6:
            self.written.append((register, word))
            self.registers[register] = word
            return self.spoilt(request)
        wanted = range(register, register + word)
        if any(each not in self.registers for each in wanted):
            return self.spoilt(sealed(address, 0x80 | function, 2))
        data = b"".join(self.registers[each].to_bytes(2, "big") for each in wanted)
        return self.spoilt(sealed(address, function, len(data), *data))


class Bench:
    """Lets devices and slaves live on one line."""

    def __init__(self, devices: list[Device], slaves: list[Slave], echo: bool = False) -> None:
        self.line = Conversation("port", devices)
        self.now_ns = 0
        self.sent: list[tuple[int, bytes]] = []
        """Requests, and when each began."""
        self.came: list[tuple[int, bytes]] = []
        """Replies, and when each had come."""
        self.readings: list[RangeReading] = []
        self.late_ns = 0
        """How much later than usual slaves answer."""
        self._slaves = slaves
        self._echo = echo
        self._coming: list[tuple[int, bytes]] = []

    def run(self, for_ns: int) -> None:
        """Let so much time pass."""
        end_ns = self.now_ns + for_ns
        while True:
            due = [each for each in self._coming if each[0] <= self.now_ns]
            self._coming = [each for each in self._coming if each[0] > self.now_ns]
            self.came += due
            step = self.line.step(self.now_ns, [data for _, data in due])
            self.readings += [each for each in step.readings if isinstance(each, RangeReading)]
            for item in step.send:
                assert isinstance(item, bytes)
                self._pass_on(item)
            next_ns = min([step.deadline_ns, *(when_ns for when_ns, _ in self._coming)])
            if next_ns > end_ns:
                break
            self.now_ns = max(self.now_ns, next_ns)
        self.now_ns = end_ns

    def _pass_on(self, request: bytes) -> None:
        self.sent.append((self.now_ns, request))
        passed_ns = self.now_ns + len(request) * BYTE_NS
        if self._echo:
            self._coming.append((passed_ns, request))
        for slave in self._slaves:
            if reply := slave.answer(request):
                came_ns = passed_ns + TURNAROUND_NS + self.late_ns + len(reply) * BYTE_NS
                self._coming.append((came_ns, reply))
