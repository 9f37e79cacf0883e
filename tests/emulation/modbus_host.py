"""A Modbus master by hand, on an emulated line in memory."""

from echogrid.emulation.buses.serial_line import SerialLine
from echogrid.emulation.devices.modbus_slave import ModbusSlave, sealed

MS = 1_000_000


class Host:
    """Sends frames and takes what comes back, each at its time."""

    def __init__(self, *slaves: ModbusSlave) -> None:
        self.line = SerialLine("port", *slaves)
        self.line.switch_on(0)
        self.now_ns = 10 * MS
        self.came_ns = 0
        """When the last reply had come."""

    def wait(self, for_ns: int) -> bytes:
        """Let so much time pass; what came meanwhile."""
        end_ns = self.now_ns + for_ns
        heard = bytearray()
        while (next_ns := self.line.next_event_ns()) <= end_ns:
            if came := b"".join(self.line.take(next_ns)):
                heard += came
                self.came_ns = next_ns
        self.now_ns = end_ns
        return bytes(heard)

    def say(self, frame: bytes | str, for_ns: int = 100 * MS) -> bytes:
        """Send a frame as it is, and take the reply."""
        data = bytes.fromhex(frame) if isinstance(frame, str) else frame
        self.line.send((data,), self.now_ns)
        return self.wait(for_ns)

    def ask(self, *body: int, for_ns: int = 100 * MS) -> bytes:
        """Send a message in its frame; the reply's message, without address and checksum."""
        reply = self.say(sealed(bytes(body)), for_ns)
        if not reply:
            return b""
        assert sealed(reply[:-2]) == reply
        assert reply[0] == body[0]
        return reply[1:-2]

    def read(self, address: int, register: int, count: int = 1, for_ns: int = 100 * MS) -> list[int]:
        """Registers."""
        said = self.ask(address, 3, register >> 8, register & 0xFF, 0, count, for_ns=for_ns)
        assert said[:2] == bytes((3, 2 * count))
        return [int.from_bytes(said[at : at + 2], "big") for at in range(2, len(said), 2)]

    def write(self, address: int, register: int, word: int) -> bytes:
        """Set a register; the reply's message."""
        return self.ask(address, 6, register >> 8, register & 0xFF, word >> 8, word & 0xFF)
