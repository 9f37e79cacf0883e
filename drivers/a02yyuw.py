"""DFRobot A02YYUW and its kin, which send FF H L SUM frames: they ping and send unasked."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from echogrid.drivers.device import Line
from echogrid.drivers.ff_frame import LENGTH, FrameFinder
from echogrid.drivers.ff_parts import PARTS, PartSettings
from echogrid.drivers.limits import require_between
from echogrid.drivers.readings import Outcome
from echogrid.drivers.role import RangerRole
from echogrid.drivers.streaming import BITS_PER_BYTE, LONGEST_LAG_MS, PATIENCE_NS, Said, StreamingRanger


class A02yyuwMake:
    """What it sends. A frame is believed when the one before adjoins it: the header occurs in data, too.

    The two need not agree: what is in doubt is where a frame begins, not what it says.
    """

    patience_ns = PATIENCE_NS

    def __init__(self, settings: "A02yyuw.Settings") -> None:
        self._codes = settings.chosen.codes
        self._frames = FrameFinder(self._codes, settings.chosen.header_summed)
        self._unconfirmed = 0
        lag_ms, lag_error_ms = settings.lags_ms
        self.delay_ns = LENGTH * BITS_PER_BYTE * 1_000_000_000 // settings.baud + round(lag_ms * 1e6)
        self.error_ns = round(lag_error_ms * 1e6)
        self.garbled = settings.garbled()

    def feed(self, chunk: bytes) -> list[Said]:
        """The believed frames."""
        said: list[Said] = []
        for millimetres, raw, adjoining in self._frames.feed(chunk):
            if not adjoining:
                self._unconfirmed += 1
            elif code := self._codes.get(millimetres):
                said.append(Said(raw, code[0], reason=code[1]))
            else:
                said.append(Said(raw, Outcome.ECHO, millimetres / 1000))
        return said

    def forget(self) -> None:
        """Start anew."""
        self._frames.forget()

    def counts(self) -> Mapping[str, int]:
        """What was not believed."""
        return {
            "bad frames": self._frames.false_headers,
            "skipped bytes": self._frames.skipped_bytes,
            "unconfirmed frames": self._unconfirmed,
        }


class A02yyuw(StreamingRanger):
    """One ranger that is only listened to."""

    bus: ClassVar[str] = "serial"
    line: ClassVar[type[Line[bytes, bytes]]] = Line
    identity: ClassVar[str] = ""

    @dataclass(frozen=True, slots=True)
    class Settings(PartSettings):
        """Its keys in a config file."""

        lag_ms: float | None = None
        """From the sound meeting the obstacle to the first byte; None: as the part has it."""
        lag_error_ms: float | None = None

        def __post_init__(self) -> None:
            PartSettings.__post_init__(self)
            for key, value in zip(("lag_ms", "lag_error_ms"), self.lags_ms, strict=True):
                require_between(key, value, 0.0, LONGEST_LAG_MS)

        @property
        def lags_ms(self) -> tuple[float, float]:
            """The lag, and how far off it may be."""
            part = PARTS[self.part]
            return (
                part.lag_ms if self.lag_ms is None else self.lag_ms,
                part.lag_error_ms if self.lag_error_ms is None else self.lag_error_ms,
            )

    def __init__(self, role: RangerRole, settings: Settings) -> None:
        """Raises ValueError if more is asked for than the part reaches."""
        require_between("max_m", role.farthest, 0.0, settings.chosen.reach_m)
        super().__init__(role, A02yyuwMake(settings))
        self.port_options: Mapping[str, object] = {"baud": settings.baud}
