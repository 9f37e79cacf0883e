"""canopen as the master of an emulated bus: what it sends is answered before it waits, so it never does."""

from typing import Any

from pytest import importorskip

from echogrid.drivers.bus import CanFrame
from echogrid.emulation.buses.can_bus import CanBus
from echogrid.emulation.devices.canopen_node import CanopenNode

canopen = importorskip("canopen", reason="canopen is not installed")
objects = importorskip("canopen.objectdictionary", reason="canopen is not installed")

MS = 1_000_000
U8, U16, U32, I8, I16, I32 = 0x05, 0x06, 0x07, 0x02, 0x03, 0x04
"""The standard's data types."""
PLAIN = {0x1000: U32, 0x1001: U8, 0x1017: U16, 0x1234: U32, 0x6007: I16, 0x6040: U16, 0x6041: U16}
PLAIN |= {0x6060: I8, 0x6061: I8, 0x6064: I32, 0x606C: I32, 0x60FF: I32}
SETTINGS = {0: U8, 1: U32, 2: U8, 3: U16, 5: U16}
MAPPING = {0: U8, **dict.fromkeys(range(1, 9), U32)}


def dictionary() -> Any:
    """What the master knows of a drive's objects; 0x1234 the drive has not."""
    found = objects.ObjectDictionary()
    for index, data_type in PLAIN.items():
        found.add_object(_variable(index, 0, data_type))
    for number in range(4):
        for base in (0x1400, 0x1800):
            found.add_object(_record(base + number, SETTINGS))
            found.add_object(_record(base + 0x200 + number, MAPPING))
    found.add_object(_record(0x1016, {0: U8, 1: U32}))
    return found


def _record(index: int, members: dict[int, int]) -> Any:
    record = objects.ODRecord(f"{index:04X}", index)
    for sub, data_type in members.items():
        record.add_member(_variable(index, sub, data_type))
    return record


def _variable(index: int, sub: int, data_type: int) -> Any:
    variable = objects.ODVariable(f"{index:04X}" if not sub else f"{index:04X}.{sub}", index, sub)
    variable.data_type = data_type
    return variable


class Master(canopen.Network):  # type: ignore[misc]  # the package may be missing: then it is Any
    """A network on an emulated bus: time goes on when it sends, or when `wait` is called."""

    def __init__(self, drive: CanopenNode) -> None:
        super().__init__()
        self.bus_of_drive = CanBus("can", 500_000, [drive])
        self.bus_of_drive.switch_on(0)
        self.now_ns = 0
        self.heard: list[CanFrame] = []

    def send_message(self, can_id: int, data: Any, remote: bool = False) -> None:
        """Send, and hear what is said within 3 ms."""
        self.bus_of_drive.send([CanFrame(can_id, bytes(data), remote=remote)], self.now_ns)
        self.wait(3)

    def wait(self, milliseconds: int) -> None:
        """Hear what is said meanwhile."""
        self.now_ns += milliseconds * MS
        for frame in self.bus_of_drive.take(self.now_ns):
            self.heard.append(frame)
            self.notify(frame.identifier, bytearray(frame.data), frame.stamp_ns * 1e-9)
