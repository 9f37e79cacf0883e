"""The kinds of MaxBotix rangers with a serial output, as their data sheets have them."""

from dataclasses import dataclass

_MS = 1_000_000


@dataclass(frozen=True, slots=True)
class Kind:
    """What the models of a kind have in common."""

    digits: int
    least: int
    """Sent for whatever is nearer."""
    most: int
    """Sent when nothing is heard, too."""
    cycle_ns: int
    sends_ns: int
    """From the ping at the cycle's beginning to the line's first bit."""
    starts_ns: int
    """From power-up to the first ping."""
    count_s: float | None = None
    """The time of flight for one; None: it has a thermometer, and counts millimetres."""
    tail: str = "\r"
    greets_ns: int = 0
    """From power-up to the text."""
    greets: bool = False

    def size(self, speed_of_sound: float) -> float:
        """m for one, at that speed of sound (m/s)."""
        return 0.001 if self.count_s is None else self.count_s * speed_of_sound / 2

    def line(self, number: int, present: bool) -> bytes:
        """`R`, the digits, and what stands behind them."""
        tail = self.tail.replace("P?", "P1" if present else "P0")
        return f"R{number:0{self.digits}d}{tail}".encode()

    def greeting(self, model: str) -> bytes:
        """The text at power-up; none for most."""
        if not self.greets:
            return b""
        text = (
            "HRXL-MaxSonar-WR",
            f"PN:{model}",
            "Copyright 2011-2013",
            "MaxBotix Inc.",
            "RoHS 1.8b090  0713",
            "TempI",
        )
        return "".join(f"{line}\r" for line in text).encode()


def _lv(tail: str = "\r") -> Kind:
    """Inches: 250 ms to boot, 49 to calibrate, then 49 a cycle, and the line in its last 4.7."""
    return Kind(3, 6, 255, 49 * _MS, 44_300_000, 299 * _MS, 147e-6, tail)


def _xl(digits: int, most: int, cycle_ns: int = 99 * _MS) -> Kind:
    """Centimetres: as inches, with longer cycles."""
    return Kind(digits, 20, most, cycle_ns, cycle_ns - 4_700_000, 250 * _MS + cycle_ns, 58e-6)


def _hr(tail: str = "\r") -> Kind:
    """Millimetres, indoors: ten cycles a second."""
    return Kind(4, 300, 5000, 100 * _MS, 93_800_000, 250 * _MS, None, tail)


def _hrxl(most: int, cycle_ms: int, sends_ms: int, least: int = 300) -> Kind:
    """Millimetres, outdoors: a text between 65 and 160 ms after power-up."""
    return Kind(*(4, least, most, cycle_ms * _MS, sends_ms * _MS, 160 * _MS), greets_ns=65 * _MS, greets=True)


_KINDS: tuple[tuple[str, Kind], ...] = (
    ("MB1000 MB1010 MB1020 MB1030 MB1040", _lv()),
    ("MB1001 MB1009", _lv(" P?\r")),
    ("MB1200 MB1210 MB1220 MB1230 MB1240", _xl(3, 765)),
    ("MB1300 MB1310 MB1320 MB1330 MB1340 MB7060 MB7070 MB7092", _xl(3, 765)),
    ("MB7052 MB7062 MB7072", _xl(3, 765, 151_500_000)),
    ("MB1260 MB1261 MB1360 MB1361 MB7066 MB7076", _xl(4, 1068)),
    ("MB1003 MB1013 MB1023 MB1033 MB1043", _hr()),
    ("MB1403 MB1413 MB1423 MB1433 MB1443", _hr(" \r")),
    ("MB7360 MB7367 MB7380 MB7387", _hrxl(5000, 133, 123)),
    ("MB7334 MB7344 MB7354 MB7364 MB7374 MB7384", _hrxl(5000, 133, 123, least=500)),
    ("MB7369 MB7389", _hrxl(5000, 148, 140)),
    ("MB7363 MB7366 MB7383 MB7386", _hrxl(9999, 166, 158, least=500)),
    ("MB7368 MB7388", _hrxl(9999, 181, 173, least=500)),
)
KINDS = {model: kind for models, kind in _KINDS for model in models.split()}


def kind_of(model: str) -> Kind:
    """The kind of a model. Raises ValueError."""
    if model not in KINDS:
        raise ValueError(f"no model {model!r} (there are: {', '.join(sorted(KINDS))})")
    return KINDS[model]
