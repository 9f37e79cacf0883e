"""What candump has recorded of every emulated controller on a kernel's bus, read by its driver."""

from collections.abc import Sequence
from math import inf

from pytest import mark

from echogrid.drivers.bus import CanFrame
from echogrid.drivers.device import State
from echogrid.drivers.readings import WheelReading

from .candump import logged, periods
from .controllers import CONTROLLERS, NODES, RATES, STARTS, can_wheels, drift, golden

JITTER_S = 0.02
"""So late half of the frames may have been sent there."""
LASTS_NS = 1_000_000_000


def test_there_is_a_row_for_every_driver_of_wheels_on_can() -> None:
    assert {controller.driver for controller in CONTROLLERS.values()} == can_wheels()


@mark.parametrize("wheel", NODES)
@mark.parametrize("name", CONTROLLERS)
def test_a_recorded_turning_is_read_as_the_distance_that_it_was(name: str, wheel: str) -> None:
    controller, frames = CONTROLLERS[name], logged(golden(name).read_text())
    device = controller.made(wheel)
    readings = [
        reading
        for frame in frames
        for reading in device.step(frame.stamp_ns, [frame]).readings
        if isinstance(reading, WheelReading)
    ]
    assert readings[-1].stamp_ns - readings[0].stamp_ns > LASTS_NS
    assert abs(drift(readings, RATES[wheel])) < controller.fineness + JITTER_S * abs(RATES[wheel])
    assert not any(reading.discontinuity for reading in readings[STARTS:])
    assert device.health(frames[-1].stamp_ns).state is State.WELL


def test_a_log_is_read_as_candump_writes_it() -> None:
    text = (
        "(1436509052.249713) vcan0 044#2A366C2BBA\n"
        "(1436509052.249714) can1 0000091B#\n"
        "(1436509053.000001) vcan0 020#R\n"
        "(1436509053.000002) vcan0 020#R8 T\n"
        "(1436509053.000003) vcan0 00008001##1112233\n"
    )
    second = 1_436_509_052_000_000_000
    expected: Sequence[CanFrame] = (
        CanFrame(0x44, bytes.fromhex("2A366C2BBA"), stamp_ns=second + 249_713_000),
        CanFrame(0x91B, b"", True, stamp_ns=second + 249_714_000),
        CanFrame(0x20, b"", remote=True, stamp_ns=second + 1_000_001_000),
        CanFrame(0x20, b"", remote=True, stamp_ns=second + 1_000_002_000),
        CanFrame(0x8001, bytes.fromhex("112233"), True, stamp_ns=second + 1_000_003_000, fd=True),
    )
    assert logged(text) == list(expected)


def test_the_period_of_frames_that_keep_coming_is_known() -> None:
    often = [CanFrame(0x20, b"", stamp_ns=number * 10_000_000) for number in range(20)]
    seldom = [CanFrame(0x21, b"", stamp_ns=number * 10_000_000) for number in range(3)]
    assert periods([*often, *seldom]) == {(0x20, False, False, 0): 0.01, (0x21, False, False, 0): inf}
