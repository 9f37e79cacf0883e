"""The host of an emulated I2C bus, which waits for each result."""

from echogrid.drivers.bus import I2cMessage, I2cResult, I2cTransfer
from echogrid.emulation.buses.i2c_bus import I2cBus
from echogrid.emulation.devices.i2c_ranger import I2cRanger
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.scene import Echo

MS = 1_000_000
ENXIO = 6
SPEED = 343.0


def wall(distance: float, margin: float = 40.0) -> Echo:
    return Echo(distance, margin, "wall")


def room(*echoes: Echo, speed: float = SPEED) -> Surroundings:
    return Surroundings(lambda fire_ns: echoes, speed)


class Host:
    """Talks to the chip that is at `address` at the time."""

    def __init__(self, chip: I2cRanger) -> None:
        self.chip = chip
        self.bus = I2cBus("i2c", 100_000, [chip])
        self.bus.switch_on(0)
        self.address = chip.address
        self.now_ns = 0

    def write(self, *data: int) -> I2cResult:
        return self._transfer(I2cMessage(self.address, write=bytes(data)))

    def take(self, count: int) -> I2cResult:
        """Read without a register."""
        return self._transfer(I2cMessage(self.address, read=count))

    def read(self, register: int, count: int) -> bytes:
        self.write(register)
        return self.take(count).data

    def wait(self, ms: float) -> None:
        self.now_ns += round(ms * MS)

    def power_cycle(self) -> None:
        self.chip.fault("off", self.now_ns, MS)
        self.wait(2)

    def _transfer(self, message: I2cMessage) -> I2cResult:
        self.bus.send((I2cTransfer((message,)),), self.now_ns)
        while not (results := self.bus.take(self.now_ns)):
            self.now_ns = self.bus.next_event_ns()
        return results[0]
