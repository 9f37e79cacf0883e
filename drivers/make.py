"""What is particular to one make of rangers that ping when told to, and the terms in which it is said."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar, Generic

from echogrid.drivers.bus import Result, Transfer
from echogrid.drivers.course import Course
from echogrid.drivers.device import State

MILLISECOND_NS = 1_000_000


@dataclass(frozen=True, slots=True)
class Trouble:
    """Why a ranger can't be used."""

    state: State
    message: str
    """With what to do about it."""


@dataclass(frozen=True, slots=True)
class Fired:
    """A ping under way, or why there is none."""

    stamp_ns: int
    """When the sound left."""
    error_ns: int
    trouble: str = ""
    """Why it did not fire; empty if it did."""
    data: bytes = b""
    """The answer, from rangers which give it as the reply to the command."""
    state: State = State.MISSING
    """What it means if it did not fire."""
    silent: bool = False
    """It fired, and says by its silence that it heard nothing."""


@dataclass(frozen=True, slots=True)
class Answer:
    """What a ranger says of a ping."""

    distances: tuple[float, ...] = ()
    """m, nearest first; none: nothing was heard."""
    nearest: float = 0.0
    """m: its own word for how near it can hear at present."""
    doubt: str = ""
    """Why this cannot be the answer; empty if it can."""
    state: State = State.FAULTY
    """What it means if it cannot."""
    gone: bool = True
    """Whether a doubtful answer means that the device has to be set up anew."""


class Make(ABC, Generic[Transfer]):
    """How rangers of one make are talked to: what to send, and what the answers mean."""

    can_listen: ClassVar[bool] = False
    """Whether it can do all but ping."""
    obeys_general_call: ClassVar[bool] = False
    """Whether one of its kind can fire all of them on the bus."""

    where: str
    """Its place on the bus, for messages."""
    idle: Transfer
    """Any transfer."""
    ping_ns: int
    """From the command to the answer."""
    patience_ns: int
    """How long past that it may be busy."""
    rest_ns: int
    """The least from a ping to the next."""

    @abstractmethod
    def set_up(self) -> Course[Transfer, Trouble | None]:
        """Make it ready to fire; what is wrong, if it can't be."""

    @abstractmethod
    def fire(self, listens: bool) -> Course[Transfer, Fired]:
        """Start a ping; or what is the same without the sound, of one that can listen."""

    @abstractmethod
    def collect(self) -> Course[Transfer, bytes]:
        """The answer; nothing while it is busy."""

    @abstractmethod
    def answer(self, data: bytes) -> Answer:
        """What the answer means."""

    def meanwhile(self) -> Course[Transfer, None]:
        """What is to be done while it pings; nothing, with most."""
        yield from ()

    def fire_all(self) -> Course[Transfer, Fired]:
        """Start a ping of all of the make on the bus; asked of those which obey a general call."""
        return (yield from self.fire(listens=False))

    def called(self, result: Result[Transfer]) -> Fired | None:
        """The ping that another one's `fire_all` started; None if this is something else."""
        del result
        return None
