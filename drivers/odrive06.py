"""ODrive's CANSimple protocol, firmware 0.6 (Pro, S1, Micro)."""

from dataclasses import dataclass
from enum import IntEnum, IntFlag
from struct import Struct

from echogrid.drivers.cansimple import UNSETTLED, Version, error_names, state_name
from echogrid.drivers.odrive_axis import AxisSettings, CansimpleAxis
from echogrid.drivers.odrive_encoder import Estimates
from echogrid.drivers.role import WheelRole


class AxisError(IntFlag):
    """The axis errors of firmware 0.6."""

    INITIALIZING = 0x1
    SYSTEM_LEVEL = 0x2
    TIMING_ERROR = 0x4
    MISSING_ESTIMATE = 0x8
    BAD_CONFIG = 0x10
    DRV_FAULT = 0x20
    MISSING_INPUT = 0x40
    DC_BUS_OVER_VOLTAGE = 0x100
    DC_BUS_UNDER_VOLTAGE = 0x200
    DC_BUS_OVER_CURRENT = 0x400
    DC_BUS_OVER_REGEN_CURRENT = 0x800
    CURRENT_LIMIT_VIOLATION = 0x1000
    MOTOR_OVER_TEMP = 0x2000
    INVERTER_OVER_TEMP = 0x4000
    VELOCITY_LIMIT_VIOLATION = 0x8000
    POSITION_LIMIT_VIOLATION = 0x10000
    WATCHDOG_TIMER_EXPIRED = 0x1000000
    ESTOP_REQUESTED = 0x2000000
    SPINOUT_DETECTED = 0x4000000
    BRAKE_RESISTOR_DISARMED = 0x8000000
    THERMISTOR_DISCONNECTED = 0x10000000
    CALIBRATION_ERROR = 0x40000000


class ProcedureResult(IntEnum):
    """How the last thing that an axis was told to do has ended."""

    SUCCESS = 0
    BUSY = 1
    CANCELLED = 2
    DISARMED = 3
    NO_RESPONSE = 4
    POLE_PAIR_CPR_MISMATCH = 5
    PHASE_RESISTANCE_OUT_OF_RANGE = 6
    PHASE_INDUCTANCE_OUT_OF_RANGE = 7
    UNBALANCED_PHASES = 8
    INVALID_MOTOR_TYPE = 9
    ILLEGAL_HALL_STATE = 10
    TIMEOUT = 11
    HOMING_WITHOUT_ENDSTOP = 12
    INVALID_STATE = 13
    NOT_CALIBRATED = 14
    NOT_CONVERGING = 15


INITIALIZING = AxisError.INITIALIZING.value
NO_POSITION = INITIALIZING | AxisError.MISSING_ESTIMATE.value


@dataclass(frozen=True, slots=True)
class Heartbeat06:
    """What an axis says of itself."""

    error: int
    state: int
    result: int
    """Of its last procedure."""
    done: int
    """Its lowest bit: the trajectory is done."""
    spare: int

    @property
    def expired(self) -> bool:
        """Whether its watchdog has let the motor go, and nothing else is wrong."""
        return self.error == AxisError.WATCHDOG_TIMER_EXPIRED

    @property
    def trustworthy(self) -> bool:
        """Whether its position is a fact; the other errors are the motor's and its supply's."""
        return not self.error & NO_POSITION and self.state not in UNSETTLED

    @property
    def zeroed(self) -> bool:
        """Whether it may have zeroed its position just now."""
        starting = self.state in UNSETTLED or bool(self.error & INITIALIZING)
        return starting and not self.error & ~NO_POSITION

    @property
    def unlike(self) -> bool:
        """Whether it is none of firmware 0.6: 0.5 has its controller's flags in the last byte."""
        return bool(self.spare)

    @property
    def unsettled(self) -> str:
        """What it is busy with while its position does not count."""
        return "INITIALIZING" if self.error & INITIALIZING else state_name(self.state)

    @property
    def trajectory_done(self) -> bool:
        """Whether it is where it was told to go."""
        return bool(self.done & 1)

    @property
    def faults(self) -> str:
        """Its errors by name, and how its last procedure has ended; empty if there are none."""
        names = list(error_names(AxisError, self.error & ~INITIALIZING))
        if names and self.result > ProcedureResult.BUSY:
            names.append(f"last procedure {_result_name(self.result)}")
        return ", ".join(names)


def _result_name(result: int) -> str:
    return ProcedureResult(result).name if result in set(ProcedureResult) else str(result)


_HEARTBEAT = Struct("<IBBBB")


def decode_heartbeat(data: bytes) -> Heartbeat06:
    """What the 8 bytes of a heartbeat say."""
    return Heartbeat06(*_HEARTBEAT.unpack(data))


class Firmware06:
    """0.6, which tells its version when it is asked."""

    name = "0.6"
    other = "0.5"
    answers = True
    clear = bytes(1)
    idle_expires = False

    def heartbeat(self, data: bytes) -> Heartbeat06:
        """What the 8 bytes of a heartbeat say."""
        return decode_heartbeat(data)

    def fits(self, version: Version | None) -> bool:
        """Whether it is of 0.6."""
        return version is not None and (version.major, version.minor) == (0, 6)


class ODrive06Axis(CansimpleAxis):
    """One axis with firmware 0.6."""

    Settings = AxisSettings

    def __init__(self, role: WheelRole, settings: AxisSettings) -> None:
        super().__init__(role, settings, Firmware06(), Estimates(role))
