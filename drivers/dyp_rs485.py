"""DYP-A02 with RS485: a ranger that speaks Modbus RTU, and pings when its distance is asked for."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from echogrid.drivers.bus import SerialTransfer
from echogrid.drivers.commanded import CommandedRanger
from echogrid.drivers.conversation import Conversation
from echogrid.drivers.course import Course
from echogrid.drivers.limits import require_between
from echogrid.drivers.make import MILLISECOND_NS, Answer, Fired, Trouble
from echogrid.drivers.modbus import ILLEGAL_ADDRESS, read
from echogrid.drivers.modbus_line import ModbusMake, ModbusSettings
from echogrid.drivers.role import RangerRole

FILTERED, REAL_TIME, TEMPERATURE = 0x0100, 0x0101, 0x0102
"""Registers. The first two are answered when they are measured, in mm."""
FILTERED_NS, REAL_TIME_NS = 520 * MILLISECOND_NS, 120 * MILLISECOND_NS
"""From the request to the answer."""
FILTERED_WITHIN_NS, REAL_TIME_WITHIN_NS = 700 * MILLISECOND_NS, 250 * MILLISECOND_NS
REST_NS = 20 * MILLISECOND_NS


class DypMake(ModbusMake):
    """Its requests."""

    patience_ns = 0
    rest_ns = REST_NS

    def __init__(self, settings: "DypRs485.Settings") -> None:
        super().__init__(settings)
        self._settings = settings
        self._greet = read(settings.address, TEMPERATURE, 1)
        self._measure = read(settings.address, FILTERED if settings.filtered else REAL_TIME, 1)
        self.ping_ns = FILTERED_NS if settings.filtered else REAL_TIME_NS
        self._within_ns = FILTERED_WITHIN_NS if settings.filtered else REAL_TIME_WITHIN_NS

    def set_up(self) -> Course[SerialTransfer, Trouble | None]:
        """Look whether it is there, by a register which it need not ping for, or may not have."""
        told = yield from self._unit.ask(self._greet, self._within_ns)
        return None if told.reply.exception == ILLEGAL_ADDRESS else told.trouble

    def fire(self, listens: bool) -> Course[SerialTransfer, Fired]:
        """Ask for the distance. It pings at some time between request and reply; it can't listen without."""
        del listens
        told = yield from self._unit.ask(self._measure, self._within_ns)
        error_ns = (told.end_ns - told.sent_ns + 1) // 2
        return Fired((told.sent_ns + told.end_ns) // 2, error_ns, data=told.raw)

    def collect(self) -> Course[SerialTransfer, bytes]:
        """Nothing: an answer would have come with the ping."""
        yield from ()
        return b""

    def answer(self, data: bytes) -> Answer:
        """What the reply means."""
        reply = self._measure.reply(data)
        if trouble := self._unit.trouble(reply):
            return Answer(doubt=reply.doubt or reply.refusal, state=trouble.state)
        (millimetres,) = reply.registers
        if millimetres in self._settings.no_echo_mm:
            return Answer()
        if millimetres in self._settings.invalid_mm:
            return Answer(doubt=f"code {millimetres:#06x}", gone=False)
        return Answer((millimetres / 1000,))


class DypRs485(CommandedRanger[SerialTransfer]):
    """One DYP-A02 on RS485."""

    bus: ClassVar[str] = "serial"
    line: ClassVar[type[Conversation]] = Conversation
    identity: ClassVar[str] = "address"

    @dataclass(frozen=True, slots=True)
    class Settings(ModbusSettings):
        """Its keys in a config file."""

        filtered: bool = False
        """Its steadier distance, which takes 520 ms instead of 120."""
        no_echo_mm: tuple[int, ...] = (0, 0xFFFD)
        """What this part says when nothing is heard: unknown, so what its kin say."""
        invalid_mm: tuple[int, ...] = (0xFFFE,)
        """What this part says when it was disturbed: unknown, so what its kin say."""

        def __post_init__(self) -> None:
            ModbusSettings.__post_init__(self)
            for code in self.no_echo_mm:
                require_between("no_echo_mm", code, 0, 0xFFFF)
            for code in self.invalid_mm:
                require_between("invalid_mm", code, 0, 0xFFFF)

    def __init__(self, role: RangerRole, settings: Settings) -> None:
        super().__init__(role, DypMake(settings))
        self.port_options: Mapping[str, object] = settings.port_options
