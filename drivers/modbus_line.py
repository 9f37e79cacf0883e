"""What drivers of Modbus devices on a serial line share: their settings, and requests as courses."""

from collections.abc import Mapping
from dataclasses import dataclass
from errno import EIO, EPROTO, ETIMEDOUT
from typing import Literal

from echogrid.drivers.bus import Result, SerialResult, SerialTransfer
from echogrid.drivers.course import Course
from echogrid.drivers.device import State
from echogrid.drivers.limits import require_between
from echogrid.drivers.make import Make, Trouble
from echogrid.drivers.modbus import Reply, Request, quiet_ns
from echogrid.drivers.serial_talk import SILENCE, trouble_of, unanswered

LEFT_ALONE = 3
"""So many times as long as it was waited for."""


@dataclass(frozen=True, slots=True)
class ModbusSettings:
    """The keys in a config file that all of them have."""

    address: int = 1
    baud: int = 9600
    parity: Literal["none", "even", "odd"] = "none"
    stop_bits: int = 1
    echo: bool = False
    """The RS485 adapter hands back what it sends."""

    def __post_init__(self) -> None:
        require_between("address", self.address, 1, 247)
        require_between("baud", self.baud, 1200, 921_600)
        require_between("stop_bits", self.stop_bits, 1, 2)

    @property
    def bits_per_byte(self) -> int:
        """Start, data, parity and stop bits; in Modbus never less than 11 (without parity, 2 stop bits)."""
        return max(11, 9 + (self.parity != "none") + self.stop_bits)

    @property
    def port_options(self) -> Mapping[str, object]:
        """What the port should be opened with."""
        return {"baud": self.baud, "parity": self.parity, "stop_bits": self.stop_bits}


@dataclass(frozen=True, slots=True)
class Told:
    """What became of a request."""

    raw: bytes
    """What came as the reply."""
    sent_ns: int
    """When the request had passed."""
    end_ns: int
    """When the reply had come."""
    reply: Reply
    why: str
    """Why there is no answer, in a few words; empty if there is one."""
    trouble: Trouble | None
    """The same, with what to do: silence, bytes that are no reply, or a refusal."""


class Unit:
    """One address on the line."""

    def __init__(self, settings: ModbusSettings) -> None:
        self.where = f"Modbus address {settings.address} ({settings.address:#04x})"
        """For messages."""
        self._baud = settings.baud
        self._echo = settings.echo
        self._byte_ns = settings.bits_per_byte * 1_000_000_000 // settings.baud
        self._quiet_ns = quiet_ns(settings.baud, settings.bits_per_byte)
        self._left_alone_ns = 0

    def ask(self, request: Request, within_ns: int) -> Course[SerialTransfer, Told]:
        """Send a request; its reply must begin within that time.

        Nothing in a reply says to which request it is. So behind a silence the device is left alone for long.
        """
        yield self._left_alone_ns
        result = yield SerialTransfer(
            (request.frame,),
            request.reply_length,
            within_ns + request.length * self._byte_ns,
            echoed=self._echo,
            quiet_ns=self._quiet_ns,
        )
        if result.errno == ETIMEDOUT:
            self._left_alone_ns = result.end_ns + LEFT_ALONE * within_ns
        sent_ns = result.sent_ns if isinstance(result, SerialResult) else result.end_ns
        reply = Reply() if result.errno else request.reply(result.data)
        why = trouble_of(result) or reply.doubt or reply.refusal
        trouble = self._unanswered(request, result) if result.errno else self.trouble(reply)
        return Told(result.data, sent_ns, result.end_ns, reply, why, trouble)

    def trouble(self, reply: Reply) -> Trouble | None:
        """Why that is no answer, if it is none."""
        if reply.doubt:
            why = f"noise, two devices at one address, or not {self._baud} baud"
            return Trouble(State.GARBLED, f"{reply.doubt} from {self.where}: {why}")
        if reply.refusal:
            return Trouble(State.FAULTY, f"{self.where} refuses: {reply.refusal}")
        return None

    def _unanswered(self, request: Request, result: Result[SerialTransfer]) -> Trouble:
        if result.errno == EIO:
            return Trouble(State.GARBLED, f"{self.where}: the adapter does not echo: set `echo = false`")
        if result.errno == EPROTO and result.data.startswith(request.frame):
            return Trouble(State.GARBLED, f"{self.where}: the adapter echoes: set `echo = true`")
        return unanswered(self.where, result, self._baud)


class ModbusMake(Make[SerialTransfer]):
    """The half of a make that is alike in all of them."""

    idle = SILENCE

    def __init__(self, settings: ModbusSettings) -> None:
        self._unit = Unit(settings)
        self.where = self._unit.where
