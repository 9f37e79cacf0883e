"""ODrive's CANSimple protocol, firmware 0.5 (ODrive v3)."""

from dataclasses import dataclass
from enum import IntFlag
from struct import Struct

from echogrid.drivers.cansimple import UNSETTLED, Version, error_names, state_name
from echogrid.drivers.limits import require_between
from echogrid.drivers.odrive_axis import AxisSettings, CansimpleAxis
from echogrid.drivers.odrive_encoder import Counts, Estimates
from echogrid.drivers.role import WheelRole

ERROR_FLAG = 0x01
TRAJECTORY_DONE = 0x80


class AxisError(IntFlag):
    """The axis errors of firmware 0.5."""

    INVALID_STATE = 0x1
    MOTOR_FAILED = 0x40
    SENSORLESS_ESTIMATOR_FAILED = 0x80
    ENCODER_FAILED = 0x100
    CONTROLLER_FAILED = 0x200
    WATCHDOG_TIMER_EXPIRED = 0x800
    MIN_ENDSTOP_PRESSED = 0x1000
    MAX_ENDSTOP_PRESSED = 0x2000
    ESTOP_REQUESTED = 0x4000
    HOMING_WITHOUT_ENDSTOP = 0x20000
    OVER_TEMP = 0x40000
    UNKNOWN_POSITION = 0x80000


EXPIRED = AxisError.WATCHDOG_TIMER_EXPIRED.value


@dataclass(frozen=True, slots=True)
class Heartbeat05:
    """What an axis says of itself."""

    error: int
    state: int
    motor: int
    """A byte whose lowest bit is the flag of an error, and whose others are 0; like the next two."""
    encoder: int
    controller: int
    """Its highest bit: the trajectory is done."""

    @property
    def expired(self) -> bool:
        """Whether its watchdog has let the motor go, and nothing else is wrong."""
        flags = (self.motor | self.encoder | self.controller) & ERROR_FLAG
        return self.error == EXPIRED and not flags

    @property
    def trustworthy(self) -> bool:
        """Whether its position is a fact; its watchdog is the motor's."""
        return not self.error & ~EXPIRED and not self.encoder & ERROR_FLAG and self.state not in UNSETTLED

    @property
    def zeroed(self) -> bool:
        """Whether it may have zeroed its position just now."""
        return self.state in UNSETTLED and not self.error

    @property
    def unlike(self) -> bool:
        """Whether it is none of firmware 0.5: 0.6 puts numbers where this has flags."""
        return bool((self.motor | self.encoder | self.controller & ~TRAJECTORY_DONE) & ~ERROR_FLAG)

    @property
    def unsettled(self) -> str:
        """The state in which its position does not count."""
        return state_name(self.state)

    @property
    def trajectory_done(self) -> bool:
        """Whether it is where it was told to go."""
        return bool(self.controller & TRAJECTORY_DONE)

    @property
    def faults(self) -> str:
        """Its errors by name; empty if there are none."""
        flags = {
            "motor error": self.motor,
            "encoder error": self.encoder,
            "controller error": self.controller,
        }
        wrong = [part for part, byte in flags.items() if byte & ERROR_FLAG]
        return ", ".join([*error_names(AxisError, self.error), *wrong])


_HEARTBEAT = Struct("<IBBBB")


def decode_heartbeat(data: bytes) -> Heartbeat05:
    """What the 8 bytes of a heartbeat say."""
    return Heartbeat05(*_HEARTBEAT.unpack(data))


class Firmware05:
    """0.5, which knows no version request. Command 0 was kept free for CANopen."""

    name = "0.5"
    other = "0.6"
    answers = False
    clear = b""
    idle_expires = True

    def heartbeat(self, data: bytes) -> Heartbeat05:
        """What the 8 bytes of a heartbeat say."""
        return decode_heartbeat(data)

    def fits(self, version: Version | None) -> bool:
        """Whether no version was told."""
        return version is None


NO_STEERING = (
    "its counts begin anew at every power-up and can't tell an angle of steering: leave counts_per_turn out"
)


class ODriveAxis(CansimpleAxis):
    """One axis with firmware 0.5."""

    @dataclass(frozen=True, slots=True)
    class Settings(AxisSettings):
        """Its keys in a config file."""

        counts_per_turn: int = 0
        """`encoder.config.cpr`: its position is taken from the encoder's counts; 0: from the estimates."""

        def __post_init__(self) -> None:
            AxisSettings.__post_init__(self)
            require_between("counts_per_turn", self.counts_per_turn, 0, 1 << 24)

    def __init__(self, role: WheelRole, settings: Settings) -> None:
        """Raises ValueError if its counts shall tell an angle of steering."""
        per_turn = settings.counts_per_turn
        if per_turn and role.steering is not None:
            raise ValueError(NO_STEERING)
        encoder = Counts(role, per_turn) if per_turn else Estimates(role)
        super().__init__(role, settings, Firmware05(), encoder)
