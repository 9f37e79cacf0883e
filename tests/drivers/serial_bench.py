"""Serial lines without input or output: played by hand, and with emulated rangers in memory."""

from collections.abc import Callable, Mapping, Sequence

from echogrid.drivers.bus import Break, Result, SerialResult, SerialTransfer
from echogrid.drivers.clock import JumpingClock
from echogrid.drivers.commanded import CommandedRanger
from echogrid.drivers.conversation import Conversation
from echogrid.drivers.device import Health, State, Step
from echogrid.drivers.readings import RangeReading, Reading
from echogrid.emulation.buses.serial_line import SerialLine
from echogrid.emulation.devices.serial_device import SerialDevice
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.scene import Echo
from echogrid.emulation.wires.memory import MemoryPort
from echogrid.runtime.pump import Pump
from echogrid.runtime.reading_queue import ReadingQueue
from echogrid.runtime.simulation import Simulation

MS = 1_000_000
SPEED = 343.0
Ranger = CommandedRanger[SerialTransfer]


def room(*distances: float, pings: list[int] | None = None) -> Surroundings:
    """Loud echoes, nearest first; the times of pings are added to the list."""
    echoes = tuple(Echo(distance, 40.0, "wall") for distance in distances)
    return Surroundings(
        lambda fire_ns: echoes, SPEED, ping=(pings if pings is not None else list[int]()).append
    )


class Asker:
    """A device which wants one transfer after the other, each from a time on, and keeps the results."""

    port_options: Mapping[str, object] = {"baud": 9600}

    def __init__(self, name: str, *wishes: tuple[int, SerialTransfer]) -> None:
        self.name = name
        self.results: list[SerialResult] = []
        self.ends_ns: list[int] = []
        self.losses = 0
        self._wishes = list(wishes)
        self._asked = 0

    def step(self, now_ns: int, received: Sequence[SerialResult]) -> Step[SerialTransfer]:
        for result in received:
            self.results.append(result)
            self.ends_ns.append(now_ns)
        if self._asked > len(self.results) or self._asked == len(self._wishes):
            return Step()
        from_ns, wish = self._wishes[self._asked]
        if from_ns > now_ns:
            return Step(deadline_ns=from_ns)
        self._asked += 1
        return Step(send=(wish,))

    def lost(self, now_ns: int) -> None:
        self.losses += 1

    def health(self, now_ns: int) -> Health:
        return Health(State.WELL, "asking", {})


class Played:
    """A conversation whose other end is played: `answers` says what a request brings, and how much later."""

    def __init__(
        self,
        askers: Sequence[Asker],
        answers: Callable[[bytes, int], Sequence[tuple[int, bytes]]] = lambda request, now_ns: (),
        coming: Sequence[tuple[int, bytes]] = (),
    ) -> None:
        self.line = Conversation("line", askers)
        self.now_ns = 0
        self.sent: list[tuple[int, bytes | Break]] = []
        self.stall_ns: Callable[[], int] = lambda: 0
        """How late each look at the line is."""
        self._answers = answers
        self._coming = sorted(coming)

    def run(self, until_ns: int) -> None:
        while True:
            came = [data for at_ns, data in self._coming if at_ns <= self.now_ns]
            self._coming = [each for each in self._coming if each[0] > self.now_ns]
            stepped_ns = self.now_ns + self.stall_ns()
            step = self.line.step(stepped_ns, came)
            self.now_ns = stepped_ns
            for item in step.send:
                self.sent.append((stepped_ns, item))
                if isinstance(item, bytes):
                    answers = self._answers(item, stepped_ns)
                    self._coming = sorted([*self._coming, *((stepped_ns + d, data) for d, data in answers)])
            next_ns = min(step.deadline_ns, self._coming[0][0] if self._coming else step.deadline_ns)
            if next_ns > until_ns:
                break
            self.now_ns = max(self.now_ns, next_ns)
        self.now_ns = until_ns


class Bench:
    """One ranger whose transfers are answered by hand, at once or after what they take."""

    def __init__(
        self, device: Ranger, reply: Callable[[tuple[bytes | Break, ...], int], bytes | int]
    ) -> None:
        """`reply` says what a request at a time brings: bytes, or an errno."""
        self.device = device
        self.now_ns = 0
        self.asked: list[tuple[int, tuple[bytes | Break, ...]]] = []
        self.readings: list[Reading] = []
        self.transfers: list[SerialTransfer] = []
        self.reply = reply
        self.lasts_ns = 3 * MS

    def run(self, for_ns: int) -> None:
        end_ns = self.now_ns + for_ns
        received: list[Result[SerialTransfer]] = []
        while True:
            step = self.device.step(self.now_ns, received)
            self.readings += step.readings
            received = [self._result(transfer) for transfer in step.send]
            if not received:
                if step.deadline_ns > end_ns:
                    break
                self.now_ns = max(self.now_ns, step.deadline_ns)
        self.now_ns = end_ns

    def _result(self, transfer: SerialTransfer) -> SerialResult:
        start_ns = self.now_ns
        self.transfers.append(transfer)
        self.asked.append((start_ns, transfer.send))
        self.now_ns += self.lasts_ns
        said = self.reply(transfer.send, start_ns)
        errno, data = (said, b"") if isinstance(said, int) else (0, said)
        return SerialResult(transfer, start_ns, self.now_ns, data, errno, start_ns + MS)

    def ranged(self) -> list[RangeReading]:
        return [reading for reading in self.readings if isinstance(reading, RangeReading)]

    def sent(self) -> list[bytes]:
        """What was sent, without breaks."""
        return [b"".join(item for item in send if isinstance(item, bytes)) for _, send in self.asked]

    @property
    def state(self) -> State:
        return self.device.health(self.now_ns).state

    @property
    def message(self) -> str:
        return self.device.health(self.now_ns).message


class Joined:
    """Emulated rangers and their drivers on one line, on the clock that jumps."""

    def __init__(self, sensors: Sequence[SerialDevice], devices: Sequence[Ranger]) -> None:
        self.clock = JumpingClock(1_000 * MS)
        self.devices = devices
        self.bus = SerialLine("line", *sensors)
        self.bus.switch_on(self.clock.now_ns())
        self._readings: list[Reading] = []
        self.line = Conversation("line", devices)
        port = MemoryPort(self.bus, self.clock)
        self.pump = Pump(self.line, port, self.clock, self._readings.extend)
        self._simulation = Simulation(self.clock, [self.pump], ReadingQueue())

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
