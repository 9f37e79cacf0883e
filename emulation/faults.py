"""The faults of one device or bus: which there are, which are active, and when each ends."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from echogrid.drivers.bus import NEVER_NS
from echogrid.emulation.errors import UnknownVerbError


@dataclass(frozen=True, slots=True)
class Verb:
    """One way to fail: what happens when it begins, and what when it ends; both are given the time (ns)."""

    begin: Callable[[int], None]
    end: Callable[[int], None]


@dataclass(frozen=True, slots=True)
class ActiveFault:
    """A fault that lasts."""

    name: str
    """The device or bus."""
    verb: str
    since_ns: int
    until_ns: int
    """NEVER_NS: until it is cleared."""


class Faults:
    """The faults of one owner by verb. One verb is active once: to begin it again moves its end."""

    def __init__(self, owner: str, verbs: Mapping[str, Verb]) -> None:
        self.verbs = verbs
        self._owner = owner
        self._active: dict[str, ActiveFault] = {}
        self.next_end_ns = NEVER_NS
        """When the next one ends by itself."""

    def add(self, name: str, verb: Verb) -> None:
        """Let there be one more."""
        self.verbs = {**self.verbs, name: verb}

    def begin(self, verb: str, now_ns: int, for_ns: int | None) -> None:
        """Begin a fault. Raises UnknownVerbError."""
        if verb not in self.verbs:
            known = ", ".join(sorted(self.verbs))
            raise UnknownVerbError(f"{self._owner}: no fault {verb!r} (there are: {known})")
        before = self._active.get(verb)
        until_ns = NEVER_NS if for_ns is None else now_ns + for_ns
        since_ns = before.since_ns if before else now_ns
        self._active[verb] = ActiveFault(self._owner, verb, since_ns, until_ns)
        self._look_ahead()
        if before is None:
            self.verbs[verb].begin(now_ns)

    def clear(self, now_ns: int) -> None:
        """End all of them."""
        for verb in tuple(self._active):
            self._end(verb, now_ns)

    def end_due(self, now_ns: int) -> None:
        """End those whose time is over, the first to end first."""
        for fault in sorted(self._active.values(), key=lambda fault: fault.until_ns):
            if fault.until_ns <= now_ns:
                self._end(fault.verb, fault.until_ns)

    def active(self) -> tuple[ActiveFault, ...]:
        """Those which last, the oldest first."""
        return tuple(self._active.values())

    def __contains__(self, verb: str) -> bool:
        return verb in self._active

    def _end(self, verb: str, now_ns: int) -> None:
        del self._active[verb]
        self._look_ahead()
        self.verbs[verb].end(now_ns)

    def _look_ahead(self) -> None:
        self.next_end_ns = min((fault.until_ns for fault in self._active.values()), default=NEVER_NS)


class Fallible(ABC):
    """What can be told to fail by name: a device or a bus."""

    def __init__(self, name: str, verbs: Mapping[str, Verb]) -> None:
        self.name = name
        self.faults = Faults(name, verbs)
        self.on_change: Callable[[], None] = _nobody_cares
        """Called when its next event may have become another."""

    def fault(self, verb: str, now_ns: int, for_ns: int | None = None) -> None:
        """Begin the fault of that name, until it is cleared or for so long. Raises UnknownVerbError."""
        self.advance(now_ns)
        self.faults.begin(verb, now_ns, for_ns)
        self.on_change()

    def clear(self, now_ns: int) -> None:
        """End all its faults."""
        self.advance(now_ns)
        self.faults.clear(now_ns)
        self.on_change()

    def advance(self, now_ns: int) -> None:
        """Do all that is due by now, in order."""
        while (event_ns := self.next_event_ns()) <= now_ns:
            if self.faults.next_end_ns <= event_ns:
                self.faults.end_due(event_ns)
            self._step(event_ns)
            self.on_change()

    def next_event_ns(self) -> int:
        """When something is due next; NEVER_NS if nothing is."""
        return min(self._next_ns(), self.faults.next_end_ns)

    @abstractmethod
    def _step(self, now_ns: int) -> None:
        """Do what is due now, if anything is."""

    @abstractmethod
    def _next_ns(self) -> int:
        """When it has something to do next, its faults aside."""


def _nobody_cares() -> None:
    """Do nothing."""
