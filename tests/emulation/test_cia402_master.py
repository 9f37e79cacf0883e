"""canopen, an independent implementation, sets our emulated drive up, reads it and turns its motor."""

from math import tau
from random import Random
from typing import Any

from pytest import approx, mark, raises

from echogrid.emulation.devices.cia402 import Cia402Drive, Cia402Options
from echogrid.emulation.devices.shaft import MotorShaft

from .canopen_host import MS, Master, canopen, dictionary

NODE = 2


class Bench:
    """A master, its node, and the drive's shaft."""

    def __init__(self, **options: Any) -> None:
        self.shaft = MotorShaft()
        chosen = Cia402Options(**{"node": NODE, "counts_per_turn": 1000, **options})
        self.drive = Cia402Drive("wheel", self.shaft, Random(1), chosen)
        self.master = Master(self.drive)
        self.node = self.master.add_node(NODE, dictionary())
        self.master.wait(300)

    def motion_pdo(self, **settings: int) -> Any:
        """Its first TPDO, holding position and velocity."""
        pdo = self.node.tpdo[1]
        pdo.read()
        pdo.clear()
        pdo.add_variable(0x6064)
        pdo.add_variable(0x606C)
        pdo.enabled = True
        for name, value in settings.items():
            setattr(pdo, name, value)
        pdo.save()
        self.node.nmt.state = "OPERATIONAL"
        return pdo


def test_canopen_reads_what_the_drive_is() -> None:
    bench = Bench(origin=-123456)
    assert bench.node.sdo[0x1000].raw == 0x00020192
    assert bench.node.sdo[0x6064].raw == -123456
    assert bench.node.sdo[0x6041].raw == 0x0250


@mark.parametrize(
    ("index", "value", "code"), [(0x1234, None, 0x06020000), (0x1000, 1, 0x06010002), (0x6060, 9, 0x06090030)]
)
def test_canopen_understands_the_drive_s_refusals(index: int, value: int | None, code: int) -> None:
    node = Bench().node
    with raises(canopen.SdoAbortedError) as refusal:
        if value is None:
            _ = node.sdo[index].raw
        else:
            node.sdo[index].raw = value
    assert refusal.value.code == code


def test_canopen_reads_the_pdos_that_the_standard_sets() -> None:
    bench = Bench()
    bench.node.tpdo.read()
    mapped = [[each.index for each in bench.node.tpdo[number].map] for number in range(1, 5)]
    assert mapped == [[0x6041], [0x6041, 0x6061], [0x6041, 0x6064], [0x6041, 0x606C]]
    assert [bench.node.tpdo[number].cob_id for number in range(1, 5)] == [0x182, 0x282, 0x382, 0x482]


def test_a_pdo_that_canopen_sets_up_comes_by_its_event_timer() -> None:
    bench = Bench(origin=-123456)
    pdo = bench.motion_pdo(trans_type=255, event_timer=20)
    before = len(bench.master.heard)
    bench.master.wait(1000)
    heard = [frame for frame in bench.master.heard[before:] if frame.identifier == 0x182]
    assert len(heard) == approx(50, abs=1)
    assert heard[0].data == bytes.fromhex("C01DFEFF00000000")
    assert (pdo["6064"].raw, pdo["606C"].raw) == (-123456, 0)


def test_a_pdo_that_canopen_synchronises_comes_at_its_sync() -> None:
    bench = Bench()
    bench.motion_pdo(trans_type=1)
    before = len(bench.master.heard)
    for _ in range(5):
        bench.master.sync.transmit()
    bench.master.wait(500)
    assert len([frame for frame in bench.master.heard[before:] if frame.identifier == 0x182]) == 5


def test_canopen_follows_its_heartbeat_and_its_emergencies() -> None:
    bench = Bench()
    bench.node.sdo[0x1017].raw = 50
    bench.node.nmt.state = "OPERATIONAL"
    bench.master.wait(200)
    assert bench.node.nmt.state == "OPERATIONAL"
    bench.drive.fault("tripped", bench.master.now_ns, 100 * MS)
    bench.master.wait(50)
    (active,) = bench.node.emcy.active
    assert (active.code, active.register) == (0x2310, 0x03)
    bench.master.wait(200)
    assert bench.node.emcy.active == []
    bench.node.nmt.state = "RESET"
    bench.master.wait(300)
    assert bench.node.nmt.state == "PRE-OPERATIONAL"


def test_canopen_turns_its_motor() -> None:
    bench = Bench()
    command = bench.node.rpdo[1]
    command.read()
    command.clear()
    command.add_variable(0x6040)
    command.add_variable(0x60FF)
    command.enabled = True
    command.save()
    bench.node.sdo[0x6060].raw = 3
    bench.node.nmt.state = "OPERATIONAL"
    command["60FF"].raw = 2000
    for word in (0x06, 0x07, 0x0F):
        command["6040"].raw = word
        command.transmit()
    assert bench.node.sdo[0x6041].raw == 0x0237
    bench.master.wait(1000)
    assert bench.shaft.rate(bench.master.now_ns) == approx(2 * tau)
    assert bench.node.sdo[0x606C].raw == approx(2000, abs=2)
