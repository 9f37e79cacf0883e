"""Random frames at the drivers that count."""

from itertools import pairwise
from math import isfinite
from random import Random
from typing import Any

from pytest import mark

from echogrid.drivers.ak_servo import AkServo
from echogrid.drivers.bus import CanFrame
from echogrid.drivers.device import Device
from echogrid.drivers.readings import WheelReading
from echogrid.drivers.role import WheelRole
from echogrid.drivers.vesc import Vesc

MS = 1_000_000
FRAMES = 100_000
"""For each driver."""
ROLE = WheelRole("wheel", fastest=30.0)
PACKETS = (9, 14, 15, 16, 27, 28, 57, 58, 0x29)


def random_frame(random: Random, now_ns: int) -> CanFrame:
    """Mostly of the device's own identifiers; now and then late, short, or another's."""
    if random.random() < 0.2:
        identifier, extended = random.randrange(1 << 29), random.random() < 0.8
    else:
        identifier, extended = random.choice(PACKETS) << 8 | random.choice((1, 1, 1, 2)), True
    length = 8 if random.random() < 0.9 else random.randrange(9)
    stamp_ns = now_ns - random.choice((0, 0, 0, 0, random.randrange(50 * MS)))
    return CanFrame(identifier, random.randbytes(length), extended, random.random() < 0.05, stamp_ns)


@mark.parametrize(
    "device",
    [Vesc(ROLE, Vesc.Settings(node=1)), AkServo(ROLE, AkServo.Settings(node=1))],
    ids=["vesc", "ak-servo"],
)
def test_random_frames_raise_nothing_and_turn_no_wheel_faster_than_it_can(device: Device[Any, Any]) -> None:
    random, now_ns = Random(5), 1000 * MS
    wheels: list[WheelReading] = []
    for number in range(FRAMES):
        now_ns += random.choice((0, 1, random.randrange(20 * MS), random.randrange(700 * MS)))
        given = device.step(now_ns, [random_frame(random, now_ns)]).readings
        wheels += [reading for reading in given if isinstance(reading, WheelReading)]
        if number % 1000 == 0:
            device.lost(now_ns)
        assert device.health(now_ns).message
    assert len(wheels) > 50
    for old, new in pairwise(wheels):
        assert isfinite(new.angle)
        reach = 0.0 if new.discontinuity else ROLE.fastest * ((new.stamp_ns - old.stamp_ns) * 1e-9 + 0.02)
        assert abs(new.angle - old.angle) <= reach + 1e-3
