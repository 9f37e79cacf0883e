"""A yaw gyro that sends its rate in a CAN frame which a DBC file describes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import ClassVar

from echogrid.drivers.bus import CanFrame
from echogrid.drivers.dbc import load_signals
from echogrid.drivers.device import Health, Line, State, Step
from echogrid.drivers.freshness import is_old
from echogrid.drivers.readings import GyroReading
from echogrid.drivers.role import GyroRole
from echogrid.drivers.yaw_gyro import GyroSettings, YawGyro


@dataclass(frozen=True, slots=True)
class GyroDbcSettings(GyroSettings):
    """Its keys in a config file."""

    file: str = field(kw_only=True)
    """The DBC file: an absolute path, or one from the working directory."""
    rate: str = field(kw_only=True)
    """The rate's message and signal, "Message.Signal"."""
    signed: bool | None = None
    """Whether the signal has a sign, where the file says it wrong."""

    def __post_init__(self) -> None:
        GyroSettings.__post_init__(self)
        if self.rate.count(".") != 1:
            raise ValueError(f'rate is {self.rate!r}: expected "Message.Signal"')


class GyroDbc(YawGyro):
    """One gyro that is only listened to."""

    bus: ClassVar[str] = "can"
    line: ClassVar[type[Line[CanFrame, CanFrame]]] = Line
    identity: ClassVar[str] = "rate"
    port_options: ClassVar[Mapping[str, object]] = {}
    """The bit rate is that of the others on its bus."""
    Settings = GyroDbcSettings

    def __init__(self, role: GyroRole, settings: GyroDbcSettings) -> None:
        """Reads the file. Raises ValueError if that or its signal can't be used."""
        super().__init__(role, settings)
        self._name = settings.rate
        (signal,) = load_signals(settings.file, [settings.rate])
        self._signal = signal.with_sign(settings.signed)
        self._short_ns: int | None = None

    def step(self, now_ns: int, received: Sequence[CanFrame]) -> Step[CanFrame]:
        """Take the frames with its signal in the order in which they came."""
        signal = self._signal
        readings: list[GyroReading] = []
        for frame in received:
            stamp_ns = frame.stamp_ns or now_ns
            if (frame.identifier, frame.extended) != (signal.identifier, signal.extended) or frame.remote:
                self._counts["other frames"] += 1
            elif len(frame.data) < signal.length:
                self._counts["short frames"] += 1
                self._short_ns = stamp_ns
            else:
                self._heard_ns = stamp_ns
                readings += self._read(stamp_ns, signal.value(frame.data), frame.data)
        return Step(tuple(readings))

    def lost(self, now_ns: int) -> None:  # noqa: ARG002 - as every device is told
        """The port was lost: what was heard counts no more."""
        self._heard_ns = self._short_ns = None

    def health(self, now_ns: int) -> Health:
        """How it is."""
        state, message = self._condition(now_ns)
        return Health(state, message, dict(self._counts))

    def _condition(self, now_ns: int) -> tuple[State, str]:
        signal = self._signal
        if self._silent(now_ns) and not is_old(self._short_ns, now_ns):
            return (
                State.WRONG_DEVICE,
                f"its frames are shorter than {signal.length} bytes: is the DBC file its own?",
            )
        if self._silent(now_ns):
            return (
                State.SILENT,
                f"no frame {signal.identifier:#x} ({self._name}): check power, wires, bit rate, "
                "and that it sends",
            )
        if not self._believed(now_ns):
            return (
                State.FAULTY,
                f"{self._name} is no number, or above fastest_dps: are unit, scale and signed right?",
            )
        return State.WELL, "turning measured"
