"""The messages that let an ODrive's axis turn at a rate: alike for every firmware."""

from math import tau
from struct import Struct

from echogrid.drivers import cansimple
from echogrid.drivers.bus import CanFrame

VELOCITY_CONTROL, PASSTHROUGH = 2, 1
IDLE, CLOSED_LOOP = 1, 8

_STATE = Struct("<I4x")
_MODE = Struct("<II")
_VELOCITY = Struct("<ff")


class OdriveCommands:
    """Enables an axis in velocity control, in which it takes a rate as it comes."""

    def __init__(self, node: int, gear: float, clear: bytes) -> None:
        """`gear` is the encoder's turns for one of the wheel, `clear` the data of Clear_Errors."""
        self.expired = False
        """Whether it is only its own watchdog that must be cleared before it can be enabled."""
        self.enabled = False
        """Whether it is we who have enabled it."""
        self._node = node
        self._turns_per_radian = gear / tau
        self._clear = clear

    def enable(self) -> tuple[CanFrame, ...]:
        """Velocity control at zero, then the closed loop."""
        self.enabled = True
        clear = (self._frame(cansimple.CLEAR_ERRORS, self._clear),) if self.expired else ()
        return (
            *clear,
            self._frame(cansimple.SET_MODE, _MODE.pack(VELOCITY_CONTROL, PASSTHROUGH)),
            *self.drive(0.0),
            self._frame(cansimple.SET_STATE, _STATE.pack(CLOSED_LOOP)),
        )

    def drive(self, rate: float) -> tuple[CanFrame, ...]:
        """Turn the wheel at that rate, rad/s; without a torque of ours."""
        return (
            self._frame(cansimple.SET_VELOCITY, _VELOCITY.pack(rate * self._turns_per_radian + 0.0, 0.0)),
        )

    def let_go(self) -> tuple[CanFrame, ...]:
        """Stand, and be idle."""
        self.enabled = False
        return (*self.drive(0.0), self._frame(cansimple.SET_STATE, _STATE.pack(IDLE)))

    def _frame(self, command: int, data: bytes) -> CanFrame:
        return CanFrame(self._node << cansimple.COMMAND_BITS | command, data)
