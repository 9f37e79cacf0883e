"""A device as a state machine that does no input or output of its own, and the line on which several hang."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum, IntEnum
from typing import Any, Generic, Protocol, TypeVar, runtime_checkable

from echogrid.drivers.bus import NEVER_NS
from echogrid.drivers.readings import Reading

In = TypeVar("In")
Out = TypeVar("Out")
In_contra = TypeVar("In_contra", contravariant=True)
Out_co = TypeVar("Out_co", covariant=True)


class Level(IntEnum):
    """Health, with the names and values of ROS diagnostics."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3


class State(Enum):
    """How a device is, by name."""

    WELL = "well"
    SETTING_UP = "setting up"
    SILENT = "silent"
    """Not a byte comes."""
    STALLED = "stalled"
    """It is there, but nothing new comes: its bus is held up."""
    FAULTY = "faulty"
    """It says that it can't measure, or says what can't be."""
    HOT = "hot"
    """It works, and is warmer than it should be."""
    STUCK = "stuck"
    """It says the same again and again, while the robot moves on."""
    MISSING = "missing"
    """No acknowledge, no reply."""
    GARBLED = "garbled"
    """Bytes without a meaning: a wrong speed, an inverted line, noise."""
    CONFLICT = "conflict"
    """Two devices answer at one address."""
    WRONG_DEVICE = "wrong device"
    """What answers is of another make, or set up otherwise."""
    PORT_LOST = "port lost"
    BUS_OFF = "bus-off"
    """CAN: after too many errors the controller takes no part in its bus."""
    ERROR_PASSIVE = "error-passive"
    """CAN: many errors, and a bus-off may follow."""
    CONGESTED = "congested"
    """CAN: what is to be sent does not go out."""
    FAILED = "failed"
    """It says that it is out of order."""
    INTERNAL = "internal error"
    """A mistake of ours."""

    @property
    def level(self) -> Level:
        """How bad that is."""
        return _LEVELS.get(self, Level.ERROR)


_LEVELS = {
    State.WELL: Level.OK,
    State.SETTING_UP: Level.STALE,
    State.SILENT: Level.STALE,
    State.STALLED: Level.STALE,
    State.FAULTY: Level.WARN,
    State.HOT: Level.WARN,
    State.STUCK: Level.WARN,
    State.ERROR_PASSIVE: Level.WARN,
}


@dataclass(frozen=True, slots=True)
class Health:
    """How a device is, in a word and a line that says what to do."""

    state: State
    message: str
    counts: Mapping[str, int]
    """Every event counted since the start, by name."""

    @property
    def level(self) -> Level:
        """How bad it is."""
        return self.state.level


@dataclass(frozen=True, slots=True)
class Step(Generic[Out_co]):
    """What a device wants after a step: readings out, something sent, and to be called again."""

    readings: tuple[Reading, ...] = ()
    send: tuple[Out_co, ...] = ()
    deadline_ns: int = NEVER_NS
    """When to step again if nothing is received before."""


class Device(Protocol[In_contra, Out_co]):
    """A sensor or controller. `In` and `Out` are what its bus carries (see bus.Port)."""

    name: str

    @property
    def port_options(self) -> Mapping[str, object]:
        """What it wants of its port unless the user says otherwise (see transports.ports)."""
        ...

    def step(self, now_ns: int, received: Sequence[In_contra]) -> Step[Out_co]:
        """Take what the bus brought (everything on it, for others too) and say what comes next."""
        ...

    def lost(self, now_ns: int) -> None:
        """The port was lost: forget half-read frames and open requests, set the device up again."""
        ...

    def health(self, now_ns: int) -> Health:
        """How it is."""
        ...


@runtime_checkable
class Departing(Protocol[Out_co]):
    """A device which is not to be left as it is: a motor."""

    def parting(self, now_ns: int) -> Sequence[Out_co]:
        """What is sent last of all, before its port is closed."""
        ...


class BusLine(Protocol[In_contra, Out_co]):
    """The devices on one bus, stepped as one."""

    name: str

    @property
    def devices(self) -> Sequence[Device[Any, Any]]:
        """All of them."""
        ...

    @property
    def counts(self) -> Mapping[str, int]:
        """Events on the bus that are no device's own, by name."""
        ...

    def step(self, now_ns: int, received: Sequence[In_contra]) -> Step[Out_co]:
        """Take what the bus brought and say what comes next."""
        ...

    def lost(self, now_ns: int) -> None:
        """The port was lost."""
        ...

    def parting(self, now_ns: int) -> Sequence[Out_co]:
        """What is sent last of all, before the port is closed."""
        ...


@dataclass(slots=True)
class Line(Generic[In, Out]):
    """The devices on one bus, stepped as one. Each sees all that comes in and takes what is its own."""

    name: str
    devices: Sequence[Device[In, Out]]
    _deadlines_ns: list[int] = field(init=False)

    def __post_init__(self) -> None:
        self._deadlines_ns = [0] * len(self.devices)

    @property
    def counts(self) -> Mapping[str, int]:
        """None: everything that comes in is the devices'."""
        return {}

    def step(self, now_ns: int, received: Sequence[In]) -> Step[Out]:
        """Step every device that is due, or all of them if something came in."""
        readings: list[Reading] = []
        send: list[Out] = []
        for index, device in enumerate(self.devices):
            if received or now_ns >= self._deadlines_ns[index]:
                step = device.step(now_ns, received)
                readings += step.readings
                send += step.send
                self._deadlines_ns[index] = step.deadline_ns
        return Step(tuple(readings), tuple(send), min(self._deadlines_ns, default=NEVER_NS))

    def lost(self, now_ns: int) -> None:
        """The port was lost."""
        for device in self.devices:
            device.lost(now_ns)
        self._deadlines_ns = [now_ns] * len(self.devices)

    def parting(self, now_ns: int) -> Sequence[Out]:
        """What is sent last of all: by each device that is not to be left as it is."""
        departing = (device for device in self.devices if isinstance(device, Departing))
        return [item for device in departing for item in device.parting(now_ns)]
