"""The messages that let a VESC turn its motor at a rate."""

from math import tau
from struct import Struct

from echogrid.drivers.bus import CanFrame

SET_CURRENT, SET_CURRENT_BRAKE, SET_RPM = 1, 2, 3
"""Packets: bits 15 to 8 of the identifier."""

_VALUE = Struct(">i")


class VescCommands:
    """A VESC is always enabled. Told to turn at 0 it would let the wheel roll: it is braked instead."""

    def __init__(self, node: int, erpm_per_radian: float, brake_amperes: float) -> None:
        """`erpm_per_radian`: electrical turns per minute for 1 rad/s of the wheel."""
        self._node = node
        self._erpm_per_radian = erpm_per_radian
        self._milliamperes = round(brake_amperes * 1000)

    def enable(self) -> tuple[CanFrame, ...]:
        """Nothing is needed."""
        return ()

    def drive(self, rate: float) -> tuple[CanFrame, ...]:
        """Turn the wheel at that rate, rad/s."""
        if not rate:
            return (self._frame(SET_CURRENT_BRAKE, self._milliamperes),)
        return (self._frame(SET_RPM, round(rate * self._erpm_per_radian)),)

    def let_go(self) -> tuple[CanFrame, ...]:
        """Brake; it lets the wheel go by itself when nothing more comes."""
        return self.drive(0.0)

    def _frame(self, packet: int, value: int) -> CanFrame:
        return CanFrame(packet << 8 | self._node, _VALUE.pack(value), extended=True)


def erpm_per_radian(gear: float, pole_pairs: int) -> float:
    """Electrical turns per minute for 1 rad/s of a wheel, for which the motor turns `gear` times."""
    return gear * pole_pairs * 60.0 / tau
