"""Random frames at a driver for CiA 402, and a drive that answers it in part."""

from dataclasses import replace
from itertools import pairwise
from math import isfinite
from random import Random

from pytest import mark

from echogrid.drivers.bus import CanFrame
from echogrid.drivers.cia402 import Cia402Axis
from echogrid.drivers.cia402_settings import Cia402Settings
from echogrid.drivers.readings import WheelReading
from echogrid.drivers.role import WheelRole
from echogrid.drivers.throttle import Throttle

MS = 1_000_000
FRAMES = 100_000
"""For each driver."""
NODE = 1
ROLE = WheelRole("wheel", fastest=30.0)
SETTINGS = Cia402Settings(counts_per_turn=4096, node=NODE)
PARTS = {0x080: 8, 0x180: 2, 0x280: 8, 0x580: 8, 0x700: 1}
"""What a drive sends, and its length."""


def random_frame(random: Random, now_ns: int) -> CanFrame:
    """Mostly of the drive's own identifiers; now and then late, short, or another's."""
    base = random.choice(tuple(PARTS))
    length = PARTS[base] if random.random() < 0.9 else random.randrange(9)
    data = random.randbytes(length)
    if base == 0x700 and random.random() < 0.9:
        data = b"\x05"
    elif base == 0x080 and random.random() < 0.5:
        data = bytes(8)
    elif base == 0x280 and random.random() < 0.5:
        data = random.randrange(200).to_bytes(4, "little") + data[4:]
    foreign = random.random() < 0.2
    identifier = random.randrange(1 << 11) if foreign else base + NODE
    stamp_ns = now_ns - random.choice((0, 0, 0, 0, random.randrange(50 * MS)))
    return CanFrame(identifier, data, random.random() < 0.02, random.random() < 0.02, stamp_ns)


def replies(random: Random, sent: tuple[CanFrame, ...], now_ns: int) -> list[CanFrame]:
    """A drive that mostly does what it is asked."""
    asked = [frame for frame in sent if frame.identifier == 0x600 + NODE and random.random() < 0.98]
    return [
        CanFrame(
            0x580 + NODE,
            (b"\x43" if frame.data[0] == 0x40 else b"\x60") + frame.data[1:4] + b"\x92\x01\0\0",
            stamp_ns=now_ns,
        )
        for frame in asked
    ]


@mark.parametrize("configure", [False, True])
def test_random_frames_raise_nothing_and_turn_no_wheel_faster_than_it_can(configure: bool) -> None:
    random, now_ns = Random(5), 1000 * MS
    throttle = Throttle(10.0, 5.0) if configure else None
    device = Cia402Axis(replace(ROLE, throttle=throttle), replace(SETTINGS, configure=configure))
    wheels: list[WheelReading] = []
    for number in range(FRAMES):
        now_ns += random.choice((0, 1, random.randrange(5 * MS), random.randrange(20 * MS)))
        if number % 20_000 == 0:
            now_ns += 1000 * MS
            device.lost(now_ns)
        if throttle and number % 3 == 0:
            throttle.ask(now_ns, random.choice((0.0, 0.0, random.uniform(-20.0, 20.0))))
        received = [random_frame(random, now_ns)]
        while received:
            step = device.step(now_ns, received)
            wheels += [reading for reading in step.readings if isinstance(reading, WheelReading)]
            received = replies(random, step.send, now_ns)
            assert configure or step.send == ()
        assert device.health(now_ns).message
    assert len(wheels) > 1000
    for old, new in pairwise(wheels):
        assert isfinite(new.angle)
        reach = 0.0 if new.discontinuity else ROLE.fastest * ((new.stamp_ns - old.stamp_ns) * 1e-9 + 0.02)
        assert abs(new.angle - old.angle) <= reach + 1e-3
