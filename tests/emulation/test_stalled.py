"""A base led by its motors, that walls hold."""

import numpy as np
import pytest
from pytest import approx

from echogrid.emulation.body import Disc
from echogrid.emulation.devices.shaft import Shaft
from echogrid.emulation.plant import Encoders
from echogrid.emulation.stalled import StallingBase
from echogrid.emulation.world import World

MS = 1_000_000
SECOND = 1000 * MS
RADIUS, TRACK = 0.06, 0.32
AT_10_CM_S = 0.1 / RADIUS


def base(*walls: tuple[float, float, float, float], exact: bool = True) -> StallingBase:
    """At the origin, looking along x."""
    table = np.array([(-9.0, -9.0, -9.0, 9.0), *walls])
    table = np.array([(-9.0, -9.0, -9.0, 9.0), *walls])
    world = World("room", table, np.zeros(len(table), np.bool_), np.zeros((0, 3)))
    encoders = Encoders(1, 0.0, 0.0, 0.0, RADIUS) if exact else Encoders(1, wheel_radius=RADIUS)
    return StallingBase(world, Disc(0.2), (0.0, 0.0, 0.0), lambda _: (), encoders, TRACK)


def driven(made: StallingBase, left: float, right: float, now_ns: int) -> tuple[Shaft, Shaft]:
    shafts = made.shaft("left"), made.shaft("right")
    for shaft, rate in zip(shafts, (left, right), strict=True):
        shaft.drive(rate, now_ns)
    return shafts


def test_it_goes_where_its_wheels_turn() -> None:
    made = base()
    left, right = driven(made, AT_10_CM_S, AT_10_CM_S, SECOND)
    x, y, yaw = made.pose(6 * SECOND)
    assert (x, y, yaw) == approx((RADIUS * left(6 * SECOND), 0.0, 0.0))
    assert x == approx(0.5, abs=0.01)
    driven(made, -1.0, 1.0, 6 * SECOND)
    turn = made.pose(8 * SECOND)[2]
    assert turn == approx((right(8 * SECOND) - left(8 * SECOND)) * RADIUS / TRACK)
    assert turn > 0.5


def test_before_a_motor_turns_it_stands() -> None:
    assert base().pose(10 * SECOND) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("since_ms", [0, 1, 3, 4])
def test_its_shafts_turn_smoothly_between_its_steps(since_ms: int) -> None:
    left, _ = driven(base(), AT_10_CM_S, AT_10_CM_S, 0)
    at_ns = 2 * SECOND + since_ms * MS
    assert left(at_ns + MS) - left(at_ns) == approx(AT_10_CM_S * 1e-3)


def test_what_it_runs_into_holds_it_and_its_wheels_until_it_backs_off() -> None:
    made = base((0.5, -1.0, 0.5, 1.0))
    left, _ = driven(made, AT_10_CM_S, AT_10_CM_S, 0)
    x, _, _ = made.pose(4 * SECOND)
    held = left(4 * SECOND)
    assert x == approx(0.3, abs=0.001)
    assert made.pose(9 * SECOND)[0] == x
    assert left(9 * SECOND + 3 * MS) == held
    (contact,) = made.plant.contacts
    assert (contact.touched.kind, contact.touched.number) == ("wall", 1)
    assert contact.speed == approx(0.1)
    driven(made, -AT_10_CM_S, -AT_10_CM_S, 9 * SECOND)
    assert made.pose(10 * SECOND)[0] == approx(x - 0.1, abs=0.005)
    assert left(10 * SECOND) == approx(held - AT_10_CM_S, abs=0.1)


def test_its_encoders_have_their_errors() -> None:
    made = base(exact=False)
    left, _ = driven(made, AT_10_CM_S, AT_10_CM_S, 0)
    off = RADIUS * left(60 * SECOND) / made.pose(60 * SECOND)[0] - 1.0
    assert 1e-4 < abs(off) < 0.02
