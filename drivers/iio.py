"""Rangers behind the Linux kernel's own drivers: SRF04, HC-SR04, PING))), SRF08, I2CXL by IIO's files.

Reading a file pings, and blocks until the kernel knows the distance or gives up: for 0.2 s at most.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from errno import ENODEV, ENOTUNIQ, errorcode
from typing import ClassVar

from echogrid.drivers.bus import IioRead, IioResult, Result
from echogrid.drivers.commanded import CommandedRanger
from echogrid.drivers.course import Course
from echogrid.drivers.device import Line, State
from echogrid.drivers.iio_kernel import (
    KERNEL_DRIVERS,
    SLOWEST,
    Failure,
    KernelDriver,
    failure_of,
    kernel_driver,
    raw_of,
    scale_of,
    told,
)
from echogrid.drivers.limits import require_between
from echogrid.drivers.make import MILLISECOND_NS, Answer, Fired, Make, Trouble
from echogrid.drivers.role import RangerRole

NAME, RAW, SCALE = "name", "in_distance_raw", "in_distance_scale"

FIRED_WITHIN_NS = 1 * MILLISECOND_NS
"""From the beginning of the read: the trigger's 10 us and the ranger's hold-off (0.75 ms with a PING))), or
three bytes on I2C."""
ENDLESS_NS = 250 * MILLISECOND_NS
"""To rest after a pulse that the kernel did not see the end of: those of some clones, when they hear nothing,
last for 0.2 s, and a trigger meanwhile does nothing."""
UNREACHABLE = ("EIO", "ENXIO", "EREMOTEIO", "ETIMEDOUT")
"""What adapters call a missing acknowledge, and the kernel a chip that is never ready."""
SHOWN = 20
"""Bytes of a text in a message."""


class IioMake(Make[IioRead]):
    """The files of one ranger. What the kernel's driver is called tells how its numbers are to be taken."""

    patience_ns = 0

    def __init__(self, role: RangerRole, settings: "Iio.Settings") -> None:
        self.where = f"IIO device {settings.device!r}"
        self.idle = IioRead(settings.device, NAME)
        self._settings = settings
        self._speed_of_sound = role.speed_of_sound
        self._kernel = settings.planned
        self._metres = 0.001
        self.ping_ns, self.rest_ns = self._kernel.ping_ns, self._kernel.rest_ns

    def set_up(self) -> Course[IioRead, Trouble | None]:
        """Look whether it is there, and whether it is a ranger."""
        name = yield from self._read(NAME)
        if name.errno:
            return self._unreadable(name.errno)
        scale = yield from self._read(SCALE)
        found = name.data.strip()[:SHOWN].decode("ascii", "replace")
        kernel, metres = kernel_driver(found), scale_of(scale.data)
        if kernel is None or metres is None:
            return self._no_ranger(found)
        if self._settings.kernel_driver and kernel is not self._settings.planned:
            return self._another(found)
        own_speed = self._settings.speed_of_sound_m_s or kernel.speed_of_sound
        self._kernel, self.rest_ns = kernel, kernel.rest_ns
        self._metres = metres * self._speed_of_sound / own_speed
        return None

    def fire(self, listens: bool) -> Course[IioRead, Fired]:
        """Ping and take the answer; the kernel knows no listening without a ping."""
        del listens
        result = yield from self._read(RAW)
        data, half_ns = told(result), FIRED_WITHIN_NS // 2
        failure = failure_of(data)
        outlasts = failure is not None and failure.with_endless_pulse
        self.rest_ns = ENDLESS_NS if outlasts else self._kernel.rest_ns
        return Fired(result.start_ns + half_ns, half_ns, data=data)

    def collect(self) -> Course[IioRead, bytes]:
        """Nothing: the answer came with the ping."""
        yield from ()
        return b""

    def answer(self, data: bytes) -> Answer:
        """What a raw value or an error means."""
        if failure := failure_of(data):
            return self._failed(failure)
        raw = raw_of(data)
        if raw is None:
            return Answer(doubt=f"{data[:SHOWN]!r} is no number", state=State.GARBLED, gone=False)
        if not 0 <= raw <= self._kernel.most_raw:
            return Answer(doubt=f"{raw} is no range (0 to {self._kernel.most_raw})", gone=False)
        if raw >= self._no_echo_raw or (raw == 0 and self._kernel.zero_is_silence):
            return Answer()
        return Answer((raw * self._metres,), nearest=self._nearest)

    @property
    def _nearest(self) -> float:
        """m: where distances begin."""
        return (self._kernel.least_raw + 0.5) * self._metres if self._kernel.least_raw else 0.0

    @property
    def _no_echo_raw(self) -> int:
        own = self._settings.no_echo_raw
        return self._kernel.no_echo_raw if own is None else own

    def _failed(self, failure: Failure) -> Answer:
        kernel, errors = self._kernel, self._settings.no_echo_errors
        if kernel.times_pulses and failure.without_pulse:
            doubt = "no echo pulse: check its power and both its wires, or its echo line is stuck"
            return Answer(doubt=doubt, state=State.MISSING, gone=False)
        if failure.name in (kernel.no_echo_errors if errors is None else errors):
            return Answer()
        if failure.name == errorcode[ENODEV]:
            return Answer(doubt="the kernel has lost it", state=State.MISSING)
        if kernel.times_pulses or failure.name not in UNREACHABLE:
            return Answer(doubt=f"the kernel says {failure.name}", gone=False)
        doubt = f"the kernel can't reach it ({failure.name}): check its power and wires"
        return Answer(doubt=doubt, state=State.MISSING, gone=False)

    def _read(self, attribute: str) -> Course[IioRead, Result[IioRead]]:
        return (yield IioRead(self._settings.device, attribute))

    def _unreadable(self, errno: int) -> Trouble:
        """Why its very name can't be read."""
        if errno == ENOTUNIQ:
            ways = "by its folder, its label, or what it hangs on"
            return Trouble(State.CONFLICT, f"several are called {self.where}: name one of them {ways}")
        if errno == ENODEV:
            look = "grep . /sys/bus/iio/devices/*/name"
            return Trouble(State.MISSING, f"no {self.where}: is its kernel driver loaded? (see: {look})")
        return Trouble(State.MISSING, f"{self.where}: cannot be read ({errorcode.get(errno, errno)})")

    def _another(self, found: str) -> Trouble:
        said = f"{self.where} is a {found!r}, not a {self._settings.kernel_driver!r}"
        return Trouble(State.WRONG_DEVICE, f"{said}: set kernel_driver, by which it is planned when to fire")

    def _no_ranger(self, found: str) -> Trouble:
        known = ", ".join(KERNEL_DRIVERS)
        return Trouble(State.WRONG_DEVICE, f"{self.where} is a {found!r}, no ultrasonic ranger ({known})")


class Iio(CommandedRanger[IioRead]):
    """One ranger that the kernel reads."""

    bus: ClassVar[str] = "iio"
    line: ClassVar[type[Line[IioResult, IioRead]]] = Line
    identity: ClassVar[str] = "device"
    port_options: ClassVar[Mapping[str, object]] = {}

    @dataclass(frozen=True, slots=True)
    class Settings:
        """Its keys in a config file."""

        device: str = "srf04"
        """Its folder, its label, its kernel driver, or what it hangs on: a name that only it has."""
        kernel_driver: str = ""
        """Its kernel driver's name: for how long it is planned to ping and to rest. By default what `device`
        says, if that is one, or the slowest."""
        no_echo_raw: int | None = None
        """From this raw value on nothing was heard; by default as the kernel's driver is known to mean it."""
        no_echo_errors: tuple[str, ...] | None = None
        """Names of the errors of a read which mean that nothing was heard; by default likewise."""
        speed_of_sound_m_s: float | None = None
        """With which the kernel or the ranger makes metres of times; by default likewise."""

        def __post_init__(self) -> None:
            if not self.device or "/" in self.device:
                raise ValueError(f"device is {self.device!r}: expected a name, without a folder")
            if self.kernel_driver and kernel_driver(self.kernel_driver) is None:
                known = ", ".join(KERNEL_DRIVERS)
                raise ValueError(f"kernel_driver is {self.kernel_driver!r}: expected one of {known}")
            if self.no_echo_raw is not None:
                require_between("no_echo_raw", self.no_echo_raw, 1, 1_000_000)
            for name in self.no_echo_errors or ():
                if name not in errorcode.values():
                    raise ValueError(f"no_echo_errors has {name!r}: expected names such as EIO, ETIMEDOUT")
            if self.speed_of_sound_m_s is not None:
                require_between("speed_of_sound_m_s", self.speed_of_sound_m_s, 300.0, 400.0)

        @property
        def planned(self) -> KernelDriver:
            """What is known of it before it has said its name."""
            return kernel_driver(self.kernel_driver or self.device) or SLOWEST

    def __init__(self, role: RangerRole, settings: Settings) -> None:
        super().__init__(role, IioMake(role, settings))
