"""Drivers of rangers on I2C with a chip played by hand, and with emulated ones on a bus in memory."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from echogrid.drivers.bus import I2cResult, I2cTransfer
from echogrid.drivers.clock import JumpingClock
from echogrid.drivers.commanded import CommandedRanger
from echogrid.drivers.device import Line, State
from echogrid.drivers.readings import Outcome, RangeReading, Reading
from echogrid.emulation.buses.i2c_bus import I2cBus
from echogrid.emulation.devices.i2c_chip import I2cChip
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.scene import Echo
from echogrid.emulation.wires.memory import MemoryPort
from echogrid.runtime.pump import Pump
from echogrid.runtime.reading_queue import ReadingQueue
from echogrid.runtime.simulation import Simulation

MS = 1_000_000
SPEED = 343.0
TRANSFER_NS = 300_000
BUSY = b"\xff"
Ranger = CommandedRanger[I2cTransfer]


def room(*distances: float) -> Surroundings:
    """Loud echoes, nearest first."""
    echoes = tuple(Echo(distance, 40.0, "wall") for distance in distances)
    return Surroundings(lambda fire_ns: echoes, SPEED)


class Bench:
    """A chip played by hand: it acknowledges, fires, and answers what `registers` says."""

    def __init__(self, device: Ranger, registers: bytes, fires: bytes = b"\x00\x52") -> None:
        self.device = device
        self.registers = registers
        self.now_ns = 0
        self.errno = 0
        self.ping_ns = 0
        self.written: list[bytes] = []
        self.fired_ns: list[int] = []
        self.readings: list[Reading] = []
        self._fires = fires

    def run(self, for_ns: int) -> None:
        """Let the device do what it wants until so much time is over."""
        end_ns = self.now_ns + for_ns
        received: list[I2cResult] = []
        while True:
            step = self.device.step(self.now_ns, received)
            self.readings += step.readings
            received = [self.result(transfer) for transfer in step.send]
            if not received:
                if step.deadline_ns > end_ns:
                    break
                self.now_ns = max(self.now_ns, step.deadline_ns)
        self.now_ns = end_ns

    def result(self, transfer: I2cTransfer) -> I2cResult:
        (message,) = transfer.messages
        start_ns = self.now_ns
        self.now_ns += TRANSFER_NS
        if self.errno:
            return I2cResult(transfer, start_ns, self.now_ns, errno=self.errno)
        if message.read:
            busy = bool(self.fired_ns) and self.now_ns < self.fired_ns[-1] + self.ping_ns
            data = BUSY * message.read if busy else self.registers[: message.read]
            return I2cResult(transfer, start_ns, self.now_ns, data)
        self.written.append(message.write)
        if message.write == self._fires:
            self.fired_ns.append(start_ns)
        return I2cResult(transfer, start_ns, self.now_ns)

    def ranged(self) -> list[RangeReading]:
        return [reading for reading in self.readings if isinstance(reading, RangeReading)]

    @property
    def state(self) -> State:
        return self.device.health(self.now_ns).state


@dataclass(frozen=True, slots=True)
class Suffered:
    """What a fault did to the first chip's driver, from half a second after its beginning."""

    states: Counter[State]
    """How often each was seen."""
    outcomes: Counter[Outcome]
    recovery_ns: int
    """From the fault's end to an echo of a driver that is well."""

    @property
    def state(self) -> State:
        """The one that was seen most often."""
        return self.states.most_common(1)[0][0]


class Joined:
    """Emulated chips and their drivers on one bus."""

    def __init__(self, chips: Sequence[I2cChip], devices: Sequence[Ranger]) -> None:
        self.clock = JumpingClock(1_000 * MS)
        self.chips = chips
        self.devices = devices
        self.bus = I2cBus("i2c", 100_000, chips)
        self.bus.switch_on(self.clock.now_ns())
        self._readings: list[Reading] = []
        port = MemoryPort(self.bus, self.clock)
        pump = Pump(Line("i2c", devices), port, self.clock, self._readings.extend)
        self._simulation = Simulation(self.clock, [pump], ReadingQueue())

    def run(self, for_ns: int) -> list[RangeReading]:
        """The readings of so much time."""
        self._readings.clear()
        self._simulation.sleep_until_ns(self.clock.now_ns() + for_ns)
        return [reading for reading in self._readings if isinstance(reading, RangeReading)]

    def states(self) -> list[State]:
        return [device.health(self.clock.now_ns()).state for device in self.devices]

    def messages(self) -> list[str]:
        return [device.health(self.clock.now_ns()).message for device in self.devices]

    def count(self, name: str) -> list[int]:
        return [device.health(self.clock.now_ns()).counts.get(name, 0) for device in self.devices]

    def suffer(self, verb: str) -> Suffered:
        """Let the first chip fail for 4 s, after it has worked for 2."""
        self.run(2_000 * MS)
        self.chips[0].fault(verb, self.clock.now_ns())
        self.run(500 * MS)
        states, outcomes = Counter[State](), Counter[Outcome]()
        for _ in range(70):
            outcomes.update(reading.outcome for reading in self.run(50 * MS))
            states[self.states()[0]] += 1
        self.chips[0].clear(self.clock.now_ns())
        ended_ns = self.clock.now_ns()
        while not (self.run(10 * MS) and self.states()[0] is State.WELL):
            assert self.clock.now_ns() < ended_ns + 10_000 * MS, self.messages()
        return Suffered(states, outcomes, self.clock.now_ns() - ended_ns)
