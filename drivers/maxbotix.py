"""MaxBotix rangers on serial ports, LV to HRXL, HRUSB and ParkSonar: they ping and send unasked."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import nan
from typing import ClassVar

from echogrid.drivers import device
from echogrid.drivers.limits import require_between
from echogrid.drivers.maxbotix_line import Line, LineFinder
from echogrid.drivers.maxbotix_models import Family, family_of
from echogrid.drivers.readings import Outcome
from echogrid.drivers.role import RangerRole
from echogrid.drivers.streaming import BITS_PER_BYTE, LONGEST_LAG_MS, Said, StreamingRanger

LEAST_LAG_MS = 30.0
"""The sound is as long on its way to an obstacle at 10 m, and no stamp may lie ahead."""


class MaxbotixMake:
    """What it sends. A line has no sum, but none can be mistaken: R and CR occur in no number."""

    def __init__(self, role: RangerRole, settings: "Maxbotix.Settings") -> None:
        family = settings.family
        self._lines = LineFinder(family.digits)
        self._model = settings.model
        self._no_echo = settings.nothing
        self._largest = max(settings.nothing, family.no_echo)
        self._metres = family.unit.scale(role.speed_of_sound)
        self._ns_per_metre = 1e9 / role.speed_of_sound
        self._farthest_ns = int(role.farthest * self._ns_per_metre)
        self._present = 0
        lag_ms, lag_error_ms = settings.lags_ms
        transfer_ns = family.length * BITS_PER_BYTE * 1_000_000_000 // settings.baud
        self.delay_ns = transfer_ns + round(lag_ms * 1e6)
        self.error_ns = round(lag_error_ms * 1e6)
        self.patience_ns = round(family.patience_ms * 1e6)
        self.garbled = (
            f"is it a {settings.model} (R and {family.digits} digits) at {settings.baud} baud? "
            "Most of these send inverted, and need an RS-232 port or an inverter"
        )

    def feed(self, chunk: bytes) -> list[Said]:
        """The lines."""
        return list(map(self._said, self._lines.feed(chunk)))

    def forget(self) -> None:
        """Start anew."""
        self._lines.forget()

    def counts(self) -> Mapping[str, int]:
        """What else there was."""
        return {
            "bad lines": self._lines.bad_lines,
            "skipped bytes": self._lines.skipped_bytes,
            "presence flags": self._present,
        }

    def _said(self, line: Line) -> Said:
        number, raw, present = line
        if present:
            self._present += 1
        if number < self._no_echo:
            distance = number * self._metres
            return Said(raw, Outcome.ECHO, distance, "", int(distance * self._ns_per_metre))
        if number <= self._largest:
            return Said(raw, Outcome.NO_ECHO, nan, "", self._farthest_ns)
        return Said(raw, Outcome.INVALID, nan, f"{number} is more than a {self._model} says: another model?")


class Maxbotix(StreamingRanger):
    """One ranger that is only listened to."""

    bus: ClassVar[str] = "serial"
    line: ClassVar[type[device.Line[bytes, bytes]]] = device.Line
    identity: ClassVar[str] = ""
    likely: ClassVar[tuple[Mapping[str, str], ...]] = ({"model": "MB1013"}, {"model": "MB1240"})
    """Settings with which one that is not known is listened to: one for each count of digits."""

    @dataclass(frozen=True, slots=True)
    class Settings:
        """Its keys in a config file."""

        model: str = "MB1013"
        """As on the label. It tells inches from centimetres: the lines do not. Taken for this one most others
        have the wrong number of digits, and give no reading rather than a wrong one."""
        baud: int = 9600
        lag_ms: float | None = None
        """From the ping to the line's first byte; None: as its data sheet has it."""
        lag_error_ms: float | None = None
        no_echo: int | None = None
        """The number sent when nothing is heard; None: the largest that it knows."""

        def __post_init__(self) -> None:
            require_between("baud", self.baud, 1200, 921_600)
            require_between("no_echo", self.nothing, 1, 10**self.family.digits - 1)
            lag_ms, lag_error_ms = self.lags_ms
            require_between("lag_ms", lag_ms, LEAST_LAG_MS, LONGEST_LAG_MS)
            require_between("lag_error_ms", lag_error_ms, 0.0, LONGEST_LAG_MS)

        @property
        def family(self) -> Family:
            """What its model has in common with others. Raises ValueError for an unknown model."""
            return family_of(self.model)

        @property
        def nothing(self) -> int:
            """The number for no echo."""
            return self.family.no_echo if self.no_echo is None else self.no_echo

        @property
        def lags_ms(self) -> tuple[float, float]:
            """The lag, and how far off it may be."""
            return (
                self.family.lag_ms if self.lag_ms is None else self.lag_ms,
                self.family.lag_error_ms if self.lag_error_ms is None else self.lag_error_ms,
            )

    def __init__(self, role: RangerRole, settings: Settings) -> None:
        """Raises ValueError if more is asked for than the model reaches."""
        reach = settings.nothing * settings.family.unit.scale(role.speed_of_sound)
        require_between("max_m", role.farthest, 0.0, round(reach, 3))
        super().__init__(role, MaxbotixMake(role, settings))
        self.port_options: Mapping[str, object] = {"baud": settings.baud}
