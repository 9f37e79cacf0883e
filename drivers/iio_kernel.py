"""What the kernel's drivers of ultrasonic rangers say, and what they mean by it."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from errno import ETIMEDOUT, errorcode

from echogrid.drivers.bus import IioRead, Result
from echogrid.drivers.make import MILLISECOND_NS

NUMBER = re.compile(rb"-?\d{1,10}")
DECIMAL = re.compile(rb"\d{1,6}\.\d{1,12}")
FAILURE = re.compile(rb"(\w+) after (\d{1,6}) ms")
MAKER = "maxbotix-"
"""Kernels differ in whether they put it before a MaxBotix part's name."""

NO_EDGE_MS = 35
"""An ETIMEDOUT that comes before that is the 20 ms for which an echo pulse is waited for; a later one is
the 40 to 50 ms (by the kernel's HZ) for which it may last."""


@dataclass(frozen=True, slots=True)
class KernelDriver:
    """One of them, and the rangers behind it."""

    speed_of_sound: float
    """m/s, with which it, or the ranger's own chip, makes metres of times."""
    no_echo_raw: int
    """From this raw value on it means that nothing was heard."""
    most_raw: int
    """More it cannot say."""
    times_pulses: bool
    """It times a pulse on a GPIO; if not, it reads a chip on I2C."""
    no_echo_errors: tuple[str, ...] = ()
    """Failed reads which mean that nothing was heard."""
    zero_is_silence: bool = False
    least_raw: int = 0
    """It says so of all that is as near or nearer; 0: it has no such value."""
    ping_ns: int = 40 * MILLISECOND_NS
    """For how long a read blocks when nothing is heard."""
    rest_ns: int = 58 * MILLISECOND_NS
    """From a ping to the next: the makers' 60 ms, less the lateness of a turn."""


PULSE_TOO_LONG = ("EIO", "ETIMEDOUT")
SRF04 = KernelDriver(343.5, 6000, 6945, times_pulses=True, no_echo_errors=PULSE_TOO_LONG)
"""A ranger that hears nothing ends its pulse after 36 ms (SRF04) or 38 ms (HC-SR04), 6.18 or 6.53 m, or so
late that the kernel gives up: beyond 40.44 ms with EIO, beyond 50 ms with ETIMEDOUT."""
PING = KernelDriver(
    343.5, 3000, 3177, times_pulses=True, no_echo_errors=PULSE_TOO_LONG, ping_ns=20 * MILLISECOND_NS
)
"""Its longest pulse is 18.5 ms, and that is the kernel's limit, too."""
SRF = KernelDriver(343.0, 1102, 1101, times_pulses=False, zero_is_silence=True)
MAXBOTIX = KernelDriver(
    *(344.8, 765, 765),
    times_pulses=False,
    least_raw=20,
    ping_ns=80 * MILLISECOND_NS,
    rest_ns=98 * MILLISECOND_NS,
)
"""I2CXL: 58 us a centimetre, 100 ms from ping to ping."""
SLOWEST = MAXBOTIX

KERNEL_DRIVERS: Mapping[str, KernelDriver] = {
    "srf04": SRF04,
    "ping": PING,
    **dict.fromkeys(("srf02", "srf08", "srf10"), SRF),
    **dict.fromkeys(("mb1202", "mb1212", "mb1222", "mb1232", "mb1242", "mb7040", "mb7137"), MAXBOTIX),
}
"""By the `name` of their devices."""


def kernel_driver(name: str) -> KernelDriver | None:
    """The driver that says this name; None if it is not one of an ultrasonic ranger."""
    return KERNEL_DRIVERS.get(name.strip().removeprefix(MAKER))


def scale_of(text: bytes) -> float | None:
    """m for each step of the raw value; None if the text tells none."""
    return float(text) or None if DECIMAL.fullmatch(text.strip()) else None


def raw_of(text: bytes) -> int | None:
    """The raw value; None if the text is none."""
    return int(text) if NUMBER.fullmatch(text) else None


@dataclass(frozen=True, slots=True)
class Failure:
    """A read that failed."""

    name: str
    """Of its error: EIO, ETIMEDOUT and so on."""
    after_ms: int

    @property
    def without_pulse(self) -> bool:
        """Whether an echo pulse was waited for in vain, if it is pulses that are timed."""
        return self.name == errorcode[ETIMEDOUT] and self.after_ms < NO_EDGE_MS

    @property
    def with_endless_pulse(self) -> bool:
        """Whether one began, and its end was waited for in vain."""
        return self.name == errorcode[ETIMEDOUT] and self.after_ms >= NO_EDGE_MS


def told(result: Result[IioRead]) -> bytes:
    """What a read told, in bytes: its text, or its error and when that came."""
    if not result.errno:
        return result.data.strip()
    name = errorcode.get(result.errno, "UNKNOWN")
    return f"{name} after {(result.end_ns - result.start_ns) // MILLISECOND_NS} ms".encode()


def failure_of(data: bytes) -> Failure | None:
    """The failure that `told` told of; None if the read did not fail."""
    found = FAILURE.fullmatch(data)
    return Failure(found[1].decode("ascii", "replace"), int(found[2])) if found else None
