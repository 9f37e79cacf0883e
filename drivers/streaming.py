"""A ranger on a serial line which pings and sends unasked, and is only listened to."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import nan
from typing import Protocol

from echogrid.drivers.device import Health, State, Step
from echogrid.drivers.readings import Outcome, RangeReading, classify
from echogrid.drivers.role import RangerRole

BITS_PER_BYTE = 10
"""8 data bits, a start and a stop bit."""
STALE_NS = 1_000_000_000


@dataclass(frozen=True, slots=True)
class Said:
    """One frame, as its make understands it."""

    raw: bytes
    outcome: Outcome
    distance: float = nan
    """m, if it is an ECHO; whether it lies within the sensor's limits is not yet looked at."""
    reason: str = ""
    """Why, when INVALID."""


class StreamMake(Protocol):
    """What the rangers of one make send."""

    delay_ns: int
    """From the sound meeting the obstacle to the frame's last byte."""
    error_ns: int
    """How far off that may be."""
    garbled: str
    """What to look for when bytes come but no frames."""

    def feed(self, chunk: bytes) -> Iterable[Said]:
        """The frames which `chunk` completes, and which are believed."""
        ...

    def forget(self) -> None:
        """Start anew, as after a pause in the stream."""
        ...

    def counts(self) -> Mapping[str, int]:
        """What was found in the stream that is no believed frame, by name."""
        ...


class StreamingRanger:
    """Takes what comes in; a frame's stamp is when it came, less what is known of its way."""

    def __init__(self, role: RangerRole, make: StreamMake) -> None:
        self.name = role.name
        self._role = role
        self._make = make
        self._counts: Counter[str] = Counter()
        self._heard_ns: int | None = None
        self._believed_ns: int | None = None
        self._latest: RangeReading | None = None

    def step(self, now_ns: int, received: Sequence[bytes]) -> Step[bytes]:
        """Take the bytes that arrived now.

        Of several frames only the last gives a reading: nobody knows how long the others were held up.
        """
        chunk = b"".join(received)
        if chunk:
            self._heard_ns = now_ns
        said = list(self._make.feed(chunk))
        if not said:
            return Step()
        self._counts["overtaken frames"] += len(said) - 1
        self._believed_ns = now_ns
        self._latest = self._reading(said[-1], now_ns - self._make.delay_ns)
        self._counts[self._latest.outcome.value] += 1
        return Step((self._latest,))

    def lost(self, now_ns: int) -> None:  # noqa: ARG002 - as every device is told
        """The port was lost."""
        self._make.forget()

    def health(self, now_ns: int) -> Health:
        """How it is."""
        state, message = self._condition(now_ns)
        return Health(state, message, {**self._counts, **self._make.counts()})

    def _condition(self, now_ns: int) -> tuple[State, str]:
        if self._heard_ns is None or now_ns - self._heard_ns > STALE_NS:
            return State.SILENT, "silent: check its power and TX wire; some parts are silent without an echo"
        if self._believed_ns is None or now_ns - self._believed_ns > STALE_NS:
            return State.GARBLED, f"bytes, but no frames: {self._make.garbled}"
        if self._latest is not None and self._latest.outcome is Outcome.INVALID:
            return State.FAULTY, f"invalid reading: {self._latest.reason}"
        return State.WELL, "ranging"

    def _reading(self, said: Said, stamp_ns: int) -> RangeReading:
        outcome, distance = said.outcome, said.distance
        if outcome is Outcome.ECHO:
            outcome, distance = classify(distance, self._role.nearest, self._role.farthest)
        return RangeReading(
            stamp_ns, self._make.error_ns, self.name, outcome, distance, said.raw, said.reason
        )
