"""A host on an emulated serial line, which waits for what comes."""

from echogrid.drivers.bus import Break
from echogrid.emulation.buses.serial_line import SerialLine
from echogrid.emulation.devices.serial_device import SerialDevice
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.scene import Echo

MS = 1_000_000
SPEED = 343.0
BREAK = Break(0.002)


def room(*distances: float, speed: float = SPEED, pings: list[int] | None = None) -> Surroundings:
    """Loud echoes, nearest first; the times of pings are added to the list."""
    echoes = tuple(Echo(distance, 40.0, "wall") for distance in distances)
    noted = pings if pings is not None else list[int]()
    return Surroundings(lambda fire_ns: echoes, speed, ping=noted.append)


class Host:
    """Sends, waits, and keeps what came with its times."""

    def __init__(self, *devices: SerialDevice) -> None:
        self.line = SerialLine("line", *devices)
        self.line.switch_on(0)
        self.now_ns = 0
        self.came_ns: list[int] = []

    def send(self, *items: bytes | Break) -> None:
        self.line.send(items, self.now_ns)

    def wait(self, for_ns: int) -> bytes:
        """What comes in so much time."""
        end_ns, data = self.now_ns + for_ns, b""
        while (event_ns := self.line.next_event_ns()) <= end_ns:
            chunk = b"".join(self.line.take(event_ns))
            self.came_ns += [event_ns] * len(chunk)
            data += chunk
        self.now_ns = end_ns
        return data

    def ask(self, *items: bytes | Break, within_ns: int = 20 * MS) -> bytes:
        """What comes in answer."""
        self.send(*items)
        return self.wait(within_ns)
