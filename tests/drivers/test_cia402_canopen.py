"""canopen, an independent implementation, as the drive that our driver sets up and reads."""

from math import tau
from typing import Any

from pytest import approx

from echogrid.drivers.bus import CanFrame
from echogrid.drivers.cia402 import Cia402Axis
from echogrid.drivers.cia402_settings import Cia402Settings
from echogrid.drivers.device import State
from echogrid.drivers.readings import WheelReading
from echogrid.drivers.role import WheelRole
from echogrid.drivers.throttle import Throttle

from .canopen_peer import Joined, dictionary

NODE = 2
MS = 1_000_000
STATES = {0x06: 0x0231, 0x07: 0x0233, 0x0F: 0x0237}
"""The status word that follows a control word."""


class Bench:
    """Our driver, and canopen's local node; the node's network state and heartbeat are canopen's own."""

    def __init__(self, throttle: Throttle | None = None, **settings: Any) -> None:
        self.now_ns = 0
        self._to_us: list[CanFrame] = []
        self.network = Joined(self._to_us.append)
        self.node = self.network.create_node(NODE, dictionary())
        chosen = {"node": NODE, "counts_per_turn": 1000, "tpdo": 1, "status_tpdo": 2, **settings}
        self.axis = Cia402Axis(WheelRole("left", throttle=throttle), Cia402Settings(**chosen))
        self.sent: list[CanFrame] = []
        self.readings: list[WheelReading] = []

    def run(self, milliseconds: int = 1) -> None:
        """Let both speak until neither has more to say."""
        self.now_ns += milliseconds * MS
        while True:
            received, self._to_us[:] = list(self._to_us), []
            step = self.axis.step(self.now_ns, received)
            self.readings += [each for each in step.readings if isinstance(each, WheelReading)]
            self.sent += step.send
            for frame in step.send:
                self.network.hear(frame)
            if not self._to_us:
                return

    def boot(self) -> None:
        """The node goes through its start, and the driver through its set-up."""
        self.node.nmt.send_command(0x81)
        self.run()
        self.network.beat()
        self.run()

    def send_pdo(self, number: int, **values: int) -> None:
        """The node sends one as it was set up to."""
        pdo = self.node.tpdo[number]
        pdo.read()
        for name, value in values.items():
            pdo[f"{name}h:0"].raw = value
        pdo.transmit()
        self.run()

    @property
    def state(self) -> State:
        return self.axis.health(self.now_ns).state


def test_canopen_s_node_is_set_up_and_started() -> None:
    bench = Bench()
    bench.boot()
    assert bench.node.nmt.state == "OPERATIONAL"
    bench.node.tpdo.read()
    motion, status = bench.node.tpdo[1], bench.node.tpdo[2]
    assert motion.enabled and status.enabled
    assert (motion.cob_id, motion.trans_type, motion.event_timer, motion.inhibit_time) == (
        0x182,
        255,
        10,
        100,
    )
    assert [(each.index, each.subindex, each.length) for each in motion.map] == [
        (0x6064, 0, 32),
        (0x606C, 0, 32),
    ]
    assert [(each.index, each.length) for each in status.map] == [(0x6041, 16)]
    assert bench.node.sdo[0x1017].raw == 100
    assert bench.sent[-1] == CanFrame(0x000, bytes.fromhex("0102"))


def test_canopen_s_pdo_and_emergency_are_read() -> None:
    bench = Bench()
    bench.boot()
    bench.send_pdo(1, **{"6064": -123456, "606C": 789})
    (reading,) = bench.readings
    assert reading.raw == bytes.fromhex("C01DFEFF15030000")
    assert (reading.angle, reading.rate) == approx((-123456 / 1000 * tau, 789 / 1000 * tau))
    assert bench.state is State.WELL
    bench.node.emcy.send(0x7310, 0x21)
    bench.run()
    assert "0x7310 (speed)" in bench.axis.health(bench.now_ns).message
    bench.node.emcy.reset()
    bench.run()
    assert bench.state is State.WELL


def test_an_object_that_canopen_s_node_has_not_is_told() -> None:
    bench = Bench()
    del bench.node.object_dictionary[0x1017]
    bench.boot()
    assert bench.state is State.FAILED
    assert "1017h:0: no such object (0x06020000)" in bench.axis.health(bench.now_ns).message


def test_canopen_s_node_is_enabled_and_told_its_velocity() -> None:
    throttle = Throttle(20.0, 10.0)
    bench = Bench(throttle)
    bench.boot()
    status = 0x0250
    for rate in [0.0] * 60 + [tau] * 80:
        throttle.ask(bench.now_ns, rate)
        bench.send_pdo(2, **{"6041": status})
        bench.network.beat()
        bench.run(10)
        words = [frame.data[0] for frame in bench.sent if frame.identifier == 0x202]
        status = STATES.get(words[-1], status) if words else status
    bench.node.rpdo.read()
    command = bench.node.rpdo[1]
    assert command.enabled
    assert bench.node.sdo[0x6060].raw == bench.node.sdo[0x6007].raw == 3
    assert bench.node.sdo[0x1016][1].raw == 127 << 16 | 500
    (last,) = [frame for frame in bench.sent if frame.identifier == command.cob_id][-1:]
    command.on_message(last.identifier, bytearray(last.data), 0.0)
    assert (command["6040h:0"].raw, command["60FFh:0"].raw) == (0x0F, 1000)
