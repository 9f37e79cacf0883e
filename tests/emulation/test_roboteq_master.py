"""canopen, an independent implementation, reads our emulated Roboteq controller."""

from math import tau
from random import Random
from typing import Any

from pytest import approx, mark, raises

from echogrid.emulation.devices.roboteq import RoboteqCanopen
from echogrid.emulation.devices.roboteq_counter import RoboteqOptions

from .canopen_host import I16, I32, U16, Master, canopen, dictionary, objects

NODE = 7
PER_TURN = 2000
BY_CHANNEL = {0x2103: I32, 0x2104: I32, 0x2105: I32, 0x2107: I16, 0x2108: I32}


def roboteq_dictionary() -> Any:
    """What the maker's manual lists (CANBus Networking Manual V2.0, p. 35), beside the standard's PDOs."""
    found = dictionary()
    for index, data_type in BY_CHANNEL.items():
        _add(found, index, dict.fromkeys((1, 2), data_type))
    _add(found, 0x2106, dict.fromkeys(range(1, 9), I32))
    for index in (0x2111, 0x2112):
        flags = objects.ODVariable(f"{index:04X}", index)
        flags.data_type = U16
        found.add_object(flags)
    return found


def _add(found: Any, index: int, members: dict[int, int]) -> None:
    record = objects.ODRecord(f"{index:04X}", index)
    for sub, data_type in members.items():
        variable = objects.ODVariable(f"{index:04X}.{sub}", index, sub)
        variable.data_type = data_type
        record.add_member(variable)
    found.add_object(record)


class Bench:
    """A master, and its controller, whose wheel turns once a second."""

    def __init__(self, **options: Any) -> None:
        def angle(now_ns: int) -> float:
            return tau * now_ns * 1e-9

        chosen = RoboteqOptions(**{"node": NODE, "counts_per_turn": PER_TURN, **options})
        self.controller = RoboteqCanopen("wheel", angle, Random(1), chosen)
        self.master = Master(self.controller)
        self.node = self.master.add_node(NODE, roboteq_dictionary())
        self.master.wait(1400)


def test_canopen_reads_its_counter_speeds_and_flags() -> None:
    bench = Bench(gear=-1.0)
    assert bench.node.sdo[0x2104][1].raw == approx(-PER_TURN, abs=10)
    assert bench.node.sdo[0x2103][1].raw == -60
    assert bench.node.sdo[0x2107][1].raw == -20
    bench.controller.fault("emergency_stop", bench.master.now_ns)
    assert (bench.node.sdo[0x2112].raw, bench.node.sdo[0x2111].raw) == (0x10, 0x09)


def test_canopen_loses_motion_by_the_relative_counter() -> None:
    bench = Bench()
    assert bench.node.sdo[0x2108][1].raw == approx(PER_TURN, abs=10)
    assert bench.node.sdo[0x2108][1].raw < 20


@mark.parametrize(("index", "sub", "code"), [(0x2105, 1, 0x06020000), (0x1234, 0, 0x06020000)])
def test_canopen_understands_its_refusals(index: int, sub: int, code: int) -> None:
    bench = Bench()
    with raises(canopen.SdoAbortedError) as refusal:
        bench.node.sdo.upload(index, sub)
    assert refusal.value.code == code


@mark.parametrize("variable", [1, 4])
def test_canopen_reads_the_mapping_and_decodes_the_variable(variable: int) -> None:
    bench = Bench(source="variable", variable=variable)
    pdo = bench.node.tpdo[(variable + 1) // 2]
    pdo.read()
    assert [(each.index, each.subindex, each.length) for each in pdo.map] == [
        (0x2106, variable - (variable + 1) % 2, 32),
        (0x2106, variable + variable % 2, 32),
    ]
    assert (pdo.event_timer, pdo.enabled) == (20, True)
    bench.master.wait(1000)
    assert pdo[f"2106.2106.{variable}"].raw == approx(2 * PER_TURN, abs=100)


def test_canopen_can_map_the_counter_itself() -> None:
    """As firmware from 2.1 on allows: then no script is needed."""
    bench = Bench(source="variable")
    bench.node.nmt.state = "PRE-OPERATIONAL"
    pdo = bench.node.tpdo[1]
    pdo.read()
    pdo.clear()
    pdo.add_variable(0x2104, 1)
    pdo.save()
    bench.node.nmt.state = "OPERATIONAL"
    bench.master.wait(1000)
    assert pdo["2104.2104.1"].raw == approx(2 * PER_TURN, abs=100)


def test_canopen_sees_its_heartbeat_and_restarts_it() -> None:
    bench = Bench()
    assert bench.node.nmt.state == "OPERATIONAL"
    bench.node.nmt.send_command(0x81)
    bench.master.wait(1000)
    assert bench.node.sdo[0x2104][1].raw == approx(0.6 * PER_TURN, abs=30)
