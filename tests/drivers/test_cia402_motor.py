from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from math import tau
from struct import unpack

from pytest import approx, mark

from echogrid.drivers.device import State
from echogrid.drivers.throttle import Throttle

from .cia402_bench import (
    BOOT,
    DISABLED,
    ENABLED,
    FAULT,
    PER_TURN,
    PRE_OPERATIONAL,
    READY,
    ROLE,
    SWITCHED_ON,
    Bench,
    emergency,
    heartbeat,
    motion,
    status,
)

COMMAND, OUR_HEARTBEAT = 0x202, 0x77F
MOTORS = {0x6060, 0x60FF, 0x6007, 0x1016, 0x1400, 0x1600}
FOLLOWS = {(DISABLED, 0x06): READY, (READY, 0x07): SWITCHED_ON, (SWITCHED_ON, 0x0F): ENABLED}
GENTLE = 10.0
"""rad/s^2."""


class Ride:
    """A drive which goes from state to state as its control word says, and whoever asks for a rate."""

    def __init__(self, refused: Mapping[tuple[int, int], int] = {}, gear: float = 1.0) -> None:
        self.throttle = Throttle(20.0, GENTLE)
        self.bench = Bench(replace(ROLE, gear=gear, throttle=self.throttle))
        self.bench.refused = dict(refused)
        self.bench.ready()
        self.word = DISABLED
        self.network = 0x05
        del self.bench.sent[:]

    def go(self, milliseconds: int, rate: float | None) -> list[tuple[int, int]]:
        """Ask for a rate for so long; the control words and velocities that the drive was sent."""
        before = len(self.bench.of(COMMAND))
        for _ in range(milliseconds // 10):
            if rate is not None:
                self.throttle.ask(self.bench.now_ns, rate)
            self.bench.hear(heartbeat(self.network), status(self.word), motion(0), after_ms=10)
            for control, _ in self.commands()[-1:]:
                self.word = FOLLOWS.get((self.word, control), self.word)
        return self.commands()[before:]

    def commands(self) -> list[tuple[int, int]]:
        """What it was sent."""
        sent = [unpack("<Hi", data) for data in self.bench.of(COMMAND)]
        return [(int(control), int(units)) for control, units in sent]


def words(commands: list[tuple[int, int]]) -> list[int]:
    return [control for control, _ in commands]


def test_nothing_that_concerns_the_motor_is_sent_before_a_rate_is_asked_for() -> None:
    ride = Ride()
    assert ride.go(2000, None) == []
    assert ride.bench.of(OUR_HEARTBEAT) == []
    assert not MOTORS & {index for index, _ in ride.bench.written}


def test_it_is_prepared_and_led_to_operation_enabled_step_by_step() -> None:
    ride = Ride()
    commands = ride.go(600, 0.0)
    assert words(commands)[:3] == [0x06, 0x07, 0x0F]
    assert {units for _, units in commands} == {0}
    assert ride.word == ENABLED
    written = ride.bench.written
    assert [written[0x1600, sub] for sub in range(3)] == [2, 0x60400010, 0x60FF0020]
    assert (written[0x1400, 1], written[0x1400, 2]) == (0x202, 255)
    assert (written[0x6060, 0], written[0x6007, 0], written[0x1016, 1]) == (3, 3, 127 << 16 | 500)


def test_it_turns_gently_at_the_rate_that_is_asked_for() -> None:
    ride = Ride(gear=-2.0)
    ride.go(600, 0.0)
    commands = ride.go(1500, 3.0)
    velocities = [-units / PER_TURN / 2 * tau for _, units in commands]
    assert velocities[-1] == approx(3.0, rel=1e-3)
    steps = [later - sooner for sooner, later in pairwise(velocities)]
    assert max(steps) <= GENTLE * 0.02 + 0.01
    assert set(words(commands)) == {0x0F}


def test_without_a_fresh_rate_it_stands() -> None:
    ride = Ride()
    ride.go(600, 0.0)
    ride.go(1000, 3.0)
    assert ride.go(400, None)[-1] == (0x0F, 0)


def test_it_is_not_enabled_while_it_is_asked_to_turn() -> None:
    ride = Ride()
    assert ride.go(1000, 3.0) == []
    assert "a command to stand" in ride.bench.message
    ride.go(600, 0.0)
    assert ride.go(600, 3.0)[-1][1] > 0


def test_our_heartbeat_lasts_from_the_first_command_until_it_is_let_go() -> None:
    ride = Ride()
    ride.go(1000, 0.0)
    assert 9 <= len(ride.bench.of(OUR_HEARTBEAT)) <= 11
    ride.throttle.release()
    commands = ride.go(1000, None)
    assert commands == [(0x02, 0)]
    assert ride.bench.written[0x1016, 1] == 0
    assert len(ride.bench.of(OUR_HEARTBEAT)) <= 12


def test_it_is_let_go_before_the_port_is_closed() -> None:
    ride = Ride()
    ride.go(600, 0.0)
    frames = ride.bench.device.parting(ride.bench.now_ns)
    assert [(frame.identifier, frame.data.hex()) for frame in frames] == [
        (COMMAND, "020000000000"),
        (0x602, "2316100100000000"),
    ]
    assert ride.bench.device.parting(ride.bench.now_ns) == ()


def test_a_fault_is_not_reset() -> None:
    ride = Ride()
    ride.go(600, 0.0)
    ride.go(600, 3.0)
    ride.word = FAULT
    ride.bench.hear(emergency(0x2310))
    commands = ride.go(1000, 3.0)
    assert words(commands) == [0x02]
    assert ride.bench.state is State.FAILED


def test_after_a_fault_it_turns_no_sooner_than_a_rate_of_zero_was_asked_for() -> None:
    ride = Ride()
    ride.go(600, 0.0)
    ride.go(600, 3.0)
    ride.word = FAULT
    ride.go(200, 3.0)
    ride.word = DISABLED
    assert ride.go(600, 3.0) == []
    ride.go(600, 0.0)
    assert ride.go(600, 3.0)[-1][1] > 0


@mark.parametrize("loss", ["heartbeat", "status", "operational", "restart"])
def test_a_drive_that_can_t_be_led_any_more_is_told_to_stop(loss: str) -> None:
    ride = Ride()
    ride.go(600, 0.0)
    ride.go(600, 3.0)
    bench, before = ride.bench, len(ride.commands())
    for _ in range(60):
        ride.throttle.ask(bench.now_ns, 3.0)
        beat = () if loss == "heartbeat" else (heartbeat(PRE_OPERATIONAL if loss == "operational" else 5),)
        word = () if loss == "status" else (status(ENABLED),)
        boot = (heartbeat(BOOT),) if loss == "restart" and len(ride.commands()) == before else ()
        bench.hear(*boot, *beat, *word, after_ms=10)
    assert words(ride.commands()[before:])[-1] == 0x02
    heartbeats = len(bench.of(OUR_HEARTBEAT))
    bench.hear(after_ms=1000)
    assert len(bench.of(OUR_HEARTBEAT)) == heartbeats


def test_after_a_lost_port_nothing_is_commanded_before_a_rate_of_zero() -> None:
    ride = Ride()
    ride.go(600, 0.0)
    ride.go(600, 3.0)
    ride.bench.device.lost(ride.bench.now_ns)
    assert ride.go(1000, 3.0) == []
    ride.go(600, 0.0)
    assert ride.go(600, 3.0)[-1][1] > 0


@mark.parametrize("refused", [(0x1016, 1), (0x6007, 0)])
def test_a_drive_that_would_not_stop_without_us_is_not_enabled(refused: tuple[int, int]) -> None:
    ride = Ride({refused: 0x06020000})
    assert ride.go(1000, 0.0) == []
    assert ride.bench.state is State.FAILED
    assert f"{refused[0]:04X}h:{refused[1]}: no such object" in ride.bench.message
    assert "it would not stop by itself if we were gone" in ride.bench.message


def test_a_drive_without_profile_velocity_is_not_enabled() -> None:
    ride = Ride({(0x6060, 0): 0x06090030})
    assert ride.go(1000, 0.0) == []
    assert ride.bench.state is State.FAILED
    assert "6060h:0: invalid value (0x06090030)" in ride.bench.message
    ride.throttle.release()
    ride.go(100, None)
    assert ride.bench.state is State.WELL
