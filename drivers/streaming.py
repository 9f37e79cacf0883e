"""A ranger on a serial line which pings and sends unasked, and is only listened to."""

from collections import Counter
from collections.abc import Mapping, Sequence
from math import nan
from typing import NamedTuple, Protocol

from echogrid.drivers.device import Health, State, Step
from echogrid.drivers.readings import Outcome, RangeReading, classify
from echogrid.drivers.role import RangerRole

BITS_PER_BYTE = 10
"""8 data bits, a start and a stop bit."""
PATIENCE_NS = 1_000_000_000
"""Most send ten times a second."""
NOTHING: Step[bytes] = Step()
"""What most steps come to."""


class Said(NamedTuple):
    """One frame, as its make understands it."""

    raw: bytes
    outcome: Outcome
    distance: float = nan
    """m, if it is an ECHO; whether it lies within the sensor's limits is not yet looked at."""
    reason: str = ""
    """Why, when INVALID."""
    flight_ns: int = 0
    """How much of the make's delay was over when the sound met the obstacle."""


LONGEST_LAG_MS = 900.0
"""What comes later than a second can't be put in order with the others."""


class StreamMake(Protocol):
    """What the rangers of one make send."""

    delay_ns: int
    """From the sound meeting the obstacle, or from a moment before that, to the frame's last byte."""
    error_ns: int
    """How far off that may be."""
    patience_ns: int
    """How long it may be silent."""
    garbled: str
    """What to look for when bytes come but no frames."""

    def feed(self, chunk: bytes) -> Sequence[Said]:
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
        self._nearest, self._farthest = role.nearest, role.farthest
        self._make = make
        self._patience_ns = make.patience_ns
        self._counts: Counter[str] = Counter()
        self._heard_ns: int | None = None
        self._awaited_ns = 0
        """Since when there are bytes but no frame."""
        self._framed_ns = 0
        self._latest: RangeReading | None = None

    def step(self, now_ns: int, received: Sequence[bytes]) -> Step[bytes]:
        """Take the bytes that arrived now.

        Of several frames only the last gives a reading: nobody knows how long the others were held up.
        """
        if not received:
            return NOTHING
        if self._heard_ns is None or now_ns - self._heard_ns > self._patience_ns:
            self._awaited_ns = now_ns
        self._heard_ns = now_ns
        said = self._make.feed(received[0] if len(received) == 1 else b"".join(received))
        if not said:
            return NOTHING
        if len(said) > 1:
            self._counts["overtaken frames"] += len(said) - 1
        self._awaited_ns = self._framed_ns = now_ns
        self._latest = reading = self._reading(said[-1], now_ns - self._make.delay_ns)
        self._counts[reading.outcome.value] += 1
        return Step((reading,))

    def lost(self, now_ns: int) -> None:  # noqa: ARG002 - as every device is told
        """The port was lost."""
        self._heard_ns = None
        self._make.forget()

    def health(self, now_ns: int) -> Health:
        """How it is."""
        state, message = self._condition(now_ns)
        return Health(state, message, {**self._counts, **self._make.counts()})

    def _condition(self, now_ns: int) -> tuple[State, str]:
        if self._heard_ns is None or now_ns - self._heard_ns > self._patience_ns:
            return (
                State.SILENT,
                "nothing comes: check power and TX wire; some parts are silent without an echo",
            )
        if now_ns - self._awaited_ns > self._patience_ns:
            return State.GARBLED, f"bytes, but no frames: {self._make.garbled}"
        if self._latest is None or now_ns - self._framed_ns > self._patience_ns:
            return State.SETTING_UP, "bytes come, no whole frame yet"
        if self._latest.outcome is Outcome.INVALID:
            return State.FAULTY, f"invalid reading: {self._latest.reason}"
        return State.WELL, "ranging"

    def _reading(self, said: Said, from_ns: int) -> RangeReading:
        raw, outcome, distance, reason, flight_ns = said
        if outcome is Outcome.ECHO and not self._nearest <= distance < self._farthest:
            outcome, distance = classify(distance, self._nearest, self._farthest)
        return RangeReading(
            from_ns + flight_ns, self._make.error_ns, self.name, outcome, distance, raw, reason
        )
