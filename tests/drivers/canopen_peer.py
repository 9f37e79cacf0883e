"""canopen's own nodes without a bus of theirs: whatever they send is handed over, so nothing waits."""

from collections.abc import Callable
from typing import Any

from pytest import importorskip

from echogrid.drivers.bus import CanFrame

canopen = importorskip("canopen", reason="canopen is not installed")
objects = importorskip("canopen.objectdictionary", reason="canopen is not installed")

U8, U16, U32, I8, I16, I32 = 0x05, 0x06, 0x07, 0x02, 0x03, 0x04
"""The standard's data types."""
PLAIN = {
    0x1000: (U32, 0x00020192),
    0x1017: (U16, 0),
    0x6007: (I16, 1),
    0x6040: (U16, 0),
    0x6041: (U16, 0x0250),
    0x6060: (I8, 0),
    0x6064: (I32, 0),
    0x606C: (I32, 0),
    0x60FF: (I32, 0),
}
"""What a drive has, beside its PDOs: type and value."""
PDOS = range(4)


def dictionary() -> Any:
    """A drive's objects, as canopen wants them."""
    found = objects.ObjectDictionary()
    for index, (data_type, default) in PLAIN.items():
        found.add_object(_variable(index, 0, data_type, default))
    _add_record(found, 0x1016, {0: (U8, 1), 1: (U32, 0)})
    for number in PDOS:
        for settings, identifier in ((0x1400, 0x202), (0x1800, 0x182)):
            times = {
                0: (U8, 5),
                1: (U32, identifier + 0x100 * number),
                2: (U8, 255),
                3: (U16, 0),
                5: (U16, 0),
            }
            _add_record(found, settings + number, times)
            mapping = {0: (U8, 0), **dict.fromkeys(range(1, 9), (U32, 0))}
            _add_record(found, settings + 0x200 + number, mapping)
    return found


def _add_record(found: Any, index: int, members: dict[int, tuple[int, int]]) -> None:
    record = objects.ODRecord(f"{index:04X}h", index)
    for sub, (data_type, default) in members.items():
        record.add_member(_variable(index, sub, data_type, default))
    found.add_object(record)


def _variable(index: int, sub: int, data_type: int, default: int) -> Any:
    variable = objects.ODVariable(f"{index:04X}h:{sub}", index, sub)
    variable.data_type, variable.default = data_type, default
    return variable


class Beating:
    """What canopen sends again and again, sent when the test says so."""

    def __init__(self, data: Any) -> None:
        self.data = bytes(data)
        self.runs = True

    def update(self, data: Any) -> None:
        """Send this from now on."""
        self.data = bytes(data)

    def stop(self) -> None:
        """No more."""
        self.runs = False


class Joined(canopen.Network):  # type: ignore[misc]  # the package may be missing: then it is Any
    """A network whose frames are handed to `carry`."""

    def __init__(self, carry: Callable[[CanFrame], None]) -> None:
        super().__init__()
        self.beating: dict[int, Beating] = {}
        self._carry = carry

    def send_message(self, can_id: int, data: Any, remote: bool = False) -> None:
        """Hand it over."""
        self._carry(CanFrame(can_id, bytes(data), remote=remote))

    def send_periodic(self, can_id: int, data: Any, period: float, remote: bool = False) -> Beating:
        """Keep it for `beat`."""
        del period, remote
        self.beating[can_id] = Beating(data)
        return self.beating[can_id]

    def beat(self) -> None:
        """Send what is due again and again once."""
        for can_id, each in self.beating.items():
            if each.runs:
                self.send_message(can_id, each.data)

    def hear(self, frame: CanFrame) -> None:
        """A frame from somebody else."""
        self.notify(frame.identifier, bytearray(frame.data), frame.stamp_ns * 1e-9)
