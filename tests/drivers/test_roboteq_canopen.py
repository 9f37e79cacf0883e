"""canopen, an independent implementation, as the controller that our driver reads."""

from math import tau
from typing import Any

from pytest import approx, mark

from echogrid.drivers.bus import CanFrame
from echogrid.drivers.device import State
from echogrid.drivers.readings import WheelReading
from echogrid.drivers.roboteq import Roboteq
from echogrid.drivers.roboteq_settings import RoboteqSettings
from echogrid.drivers.role import WheelRole

from .canopen_peer import I32, U16, Joined, dictionary, objects

NODE = 4
MS = 1_000_000
PER_TURN = 1000


def roboteq_dictionary() -> Any:
    """The maker's counters, variables and flags, beside the standard's PDOs."""
    found = dictionary()
    for index, subs in ((0x2104, 2), (0x2105, 2), (0x2106, 8)):
        record = objects.ODRecord(f"{index:04X}", index)
        for sub in range(1, subs + 1):
            record.add_member(_variable(f"{index:04X}.{sub}", index, sub, I32))
        found.add_object(record)
    for index in (0x2111, 0x2112):
        found.add_object(_variable(f"{index:04X}", index, 0, U16))
    return found


def _variable(name: str, index: int, sub: int, data_type: int) -> Any:
    variable = objects.ODVariable(name, index, sub)
    variable.data_type, variable.default = data_type, 0
    return variable


class Bench:
    """Our driver, and canopen's local node."""

    def __init__(self, **settings: Any) -> None:
        self.now_ns = 1000 * MS
        self._to_us: list[CanFrame] = []
        self.network = Joined(self._to_us.append)
        self.node = self.network.create_node(NODE, roboteq_dictionary())
        self.device = Roboteq(
            WheelRole("left"), RoboteqSettings(**{"node": NODE, "counts_per_turn": PER_TURN, **settings})
        )
        self.readings: list[WheelReading] = []

    def run(self, milliseconds: int = 100) -> State:
        """Go on so long, with a heartbeat at the start; how it is then."""
        self.network.send_message(0x700 + NODE, b"\x05")
        for _ in range(milliseconds):
            self.now_ns += MS
            received, self._to_us[:] = list(self._to_us), []
            step = self.device.step(self.now_ns, received)
            self.readings += [each for each in step.readings if isinstance(each, WheelReading)]
            for frame in step.send:
                self.network.hear(frame)
        return self.device.health(self.now_ns).state


@mark.parametrize(
    ("settings", "index", "sub"),
    [({}, 0x2104, 1), ({"channel": 2}, 0x2104, 2), ({"encoder": "brushless", "channel": 2}, 0x2105, 2)],
)
def test_canopen_answers_for_the_counter(settings: dict[str, Any], index: int, sub: int) -> None:
    bench = Bench(**settings)
    bench.node.sdo[index][sub].raw = -123456
    assert bench.run() is State.WELL
    assert bench.readings[-1].angle == approx(-123.456 * tau)


def test_canopen_s_refusal_is_told() -> None:
    bench = Bench(channel=3)
    assert bench.run() is State.WRONG_DEVICE
    message = bench.device.health(bench.now_ns).message
    assert message.startswith("2104h:3: no such sub-index (0x06090011)")


def test_canopen_s_flags_are_told() -> None:
    bench = Bench()
    bench.node.sdo[0x2111].raw, bench.node.sdo[0x2112].raw = 0x0008, 0x0014
    assert bench.run() is State.FAILED
    assert bench.device.health(bench.now_ns).message.startswith("undervoltage, emergency stop: release it")


@mark.parametrize("variable", [1, 2, 7, 8])
def test_a_variable_in_a_pdo_that_canopen_packs_is_read(variable: int) -> None:
    bench = Bench(source="variable", variable=variable)
    pdo = bench.node.tpdo[(variable + 1) // 2]
    pdo.read()
    pdo.clear()
    first = variable - (variable + 1) % 2
    for sub in (first, first + 1):
        pdo.add_variable(0x2106, sub)
    pdo.cob_id = 0x80 + 0x100 * ((variable + 1) // 2) + NODE
    pdo[f"2106.2106.{variable}"].raw = 1 - 2**31
    pdo.transmit()
    assert bench.run() is State.WELL
    assert bench.readings[-1].angle == approx((1 - 2**31) / PER_TURN * tau)
