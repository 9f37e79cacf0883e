"""An emulated CANopen node (CiA 301): its network state, heartbeats, objects and PDOs."""

from abc import abstractmethod
from collections.abc import Mapping
from random import Random

from echogrid.drivers.bus import NEVER_NS, CanFrame
from echogrid.emulation.devices.can_node import CanNode
from echogrid.emulation.devices.canopen_objects import Dictionary, Item, Key
from echogrid.emulation.devices.canopen_pdos import Pdo, Sending

BOOT, STOPPED, OPERATIONAL, PRE_OPERATIONAL = 0x00, 0x04, 0x05, 0x7F
_START, _STOP, _ENTER_PRE_OPERATIONAL, _RESET_NODE, _RESET_COMMUNICATION = 0x01, 0x02, 0x80, 0x81, 0x82
_SYNC, _EMERGENCY, _HEARTBEAT = 0x080, 0x080, 0x700
_REPLY, _REQUEST = 0x580, 0x600
_WRITTEN = 0x60
"""The reply to a write."""
_BOOT_NS = 200_000_000
"""From power-up to the boot-up message: a guess."""
_REPLY_NS = 1_000_000
"""From a request to its reply: a guess."""
_MASTER_LOST, _PDO_TOO_SHORT = 0x8130, 0x8210
_COMMUNICATION_ERROR = 0x11
"""In the error register: generic, and communication."""


class CanopenNode(CanNode):
    """Serves its objects, and sends and takes PDOs while it is operational."""

    def __init__(self, name: str, node: int, random: Random, objects: Mapping[Key, Item]) -> None:
        super().__init__(name)
        self.state = BOOT
        self.dictionary = Dictionary()
        self.dictionary.add(self._communication(node) | dict(objects))
        self._node = node
        self._random = random
        self._sendings: tuple[Sending, ...] = ()
        self._received: tuple[Pdo, ...] = ()
        self._boot_ns = self._beat_ns = self._master_due_ns = NEVER_NS
        self._errors: dict[int, int] = {}

    def add_pdos(self, sent: Mapping[int, tuple[Key, ...]], received: Mapping[int, tuple[Key, ...]]) -> None:
        """Have these PDOs: what is in them from power-up on, by their number from 1 on."""
        self._sendings = tuple(
            Sending(Pdo(self.dictionary, 0x17FF + number, 0x80 + 0x100 * number + self._node, keys))
            for number, keys in sent.items()
        )
        self._received = tuple(
            Pdo(self.dictionary, 0x13FF + number, 0x100 + 0x100 * number + self._node, keys)
            for number, keys in received.items()
        )

    def receive(self, frame: CanFrame, now_ns: int) -> None:
        """Take what concerns it."""
        if frame.extended or frame.remote or self.state == BOOT:
            return
        if frame.identifier == 0 and len(frame.data) == 2 and frame.data[1] in (0, self._node):
            self._commanded(frame.data[0], now_ns)
        elif frame.identifier == _REQUEST + self._node and len(frame.data) == 8:
            self._serve(frame.data, now_ns)
        elif frame.identifier == _SYNC and self.state == OPERATIONAL:
            for sending in self._sendings:
                if sending.synchronised():
                    self._send_pdo(sending, now_ns)
        elif frame.identifier == _HEARTBEAT + (self._consumed() >> 16):
            self._master_heard(now_ns)
        elif self.state == OPERATIONAL:
            self._take_pdo(frame, now_ns)

    def changed(self, key: Key, now_ns: int) -> None:
        """An object has another value: PDOs by event tell that."""
        for sending in self._sendings:
            if key in sending.pdo.keys():  # noqa: SIM118 - not a mapping's
                sending.want(now_ns)

    def alarm(self, code: int, register: int, now_ns: int) -> None:
        """Tell an error that has come."""
        self._errors[code] = register
        self._send_emergency(code, now_ns)

    def calm(self, code: int, now_ns: int) -> None:
        """An error has gone; if it was the last, that is told, else which there still is."""
        if self._errors.pop(code, None) is not None:
            self._send_emergency(next(iter(self._errors), 0), now_ns)

    @abstractmethod
    def master_lost(self, now_ns: int) -> None:
        """Its master's heartbeat stays away."""

    def _power_up(self, now_ns: int) -> None:
        self.dictionary.reset()
        self._errors.clear()
        self._boot_ns = now_ns + _BOOT_NS

    def _power_down(self) -> None:
        self.state = BOOT
        self._boot_ns = self._beat_ns = self._master_due_ns = NEVER_NS
        self.withdraw()

    def _next_ns(self) -> int:
        due_ns = min(self._boot_ns, self._beat_ns, self._master_due_ns)
        if self.state == OPERATIONAL:
            return min(due_ns, *(sending.due_ns() for sending in self._sendings))
        return due_ns

    def _step(self, now_ns: int) -> None:
        if now_ns >= self._boot_ns:
            self._boot_ns = NEVER_NS
            self._post(_HEARTBEAT + self._node, bytes((BOOT,)), now_ns)
            self.state = PRE_OPERATIONAL
            self._produce(self.dictionary.value(0x1017), now_ns)
        if now_ns >= self._beat_ns:
            self._post(_HEARTBEAT + self._node, bytes((self.state,)), now_ns)
            self._beat_ns += self.dictionary.value(0x1017) * 1_000_000
        if now_ns >= self._master_due_ns:
            self._master_due_ns = NEVER_NS
            self.alarm(_MASTER_LOST, _COMMUNICATION_ERROR, now_ns)
            self.master_lost(now_ns)
            self.state = PRE_OPERATIONAL
        if self.state == OPERATIONAL:
            for sending in self._sendings:
                if now_ns >= sending.due_ns():
                    self._send_pdo(sending, now_ns)

    def _communication(self, node: int) -> dict[Key, Item]:
        return {
            (0x1001, 0): Item("B", read=lambda _: self._register(), writable=False, mappable=True),
            (0x1014, 0): Item("I", _EMERGENCY + node, writable=False),
            (0x1016, 0): Item("B", 1, writable=False),
            (0x1016, 1): Item("I", written=self._consume),
            (0x1017, 0): Item("H", written=self._produce),
            (0x1018, 0): Item("B", 1, writable=False),
            (0x1018, 1): Item("I", 0, writable=False),
        }

    def _produce(self, period_ms: int, now_ns: int) -> None:
        self._beat_ns = now_ns + period_ms * 1_000_000 if period_ms else NEVER_NS

    def _consumed(self) -> int:
        return self.dictionary.value(0x1016, 1)

    def _consume(self, value: int, now_ns: int) -> None:
        """It is watched from its first heartbeat on."""
        del value
        self._master_due_ns = NEVER_NS
        self.calm(_MASTER_LOST, now_ns)

    def _master_heard(self, now_ns: int) -> None:
        if within_ms := self._consumed() & 0xFFFF:
            self._master_due_ns = now_ns + within_ms * 1_000_000
            self.calm(_MASTER_LOST, now_ns)

    def _commanded(self, command: int, now_ns: int) -> None:
        if command == _START and self.state != OPERATIONAL:
            self.state = OPERATIONAL
            for sending in self._sendings:
                sending.restart(now_ns)
        elif command == _STOP:
            self.state = STOPPED
        elif command == _ENTER_PRE_OPERATIONAL:
            self.state = PRE_OPERATIONAL
        elif command in (_RESET_NODE, _RESET_COMMUNICATION):
            self.reboot(now_ns)

    def reboot(self, now_ns: int) -> None:
        """Start afresh without having been off."""
        self.lose_power("reboot", now_ns)
        self.restore_power("reboot", now_ns)

    def _serve(self, request: bytes, now_ns: int) -> None:
        if self.state == STOPPED or not (reply := self.dictionary.serve(request, now_ns)):
            return
        self._post(_REPLY + self._node, reply, now_ns + _REPLY_NS)
        for sending in self._sendings:
            if reply[0] == _WRITTEN and sending.pdo.settings == int.from_bytes(reply[1:3], "little"):
                sending.settle(now_ns)

    def _take_pdo(self, frame: CanFrame, now_ns: int) -> None:
        for pdo in self._received:
            if pdo.on and pdo.identifier == frame.identifier and not pdo.unpack(frame.data, now_ns):
                self._send_emergency(_PDO_TOO_SHORT, now_ns)

    def _send_pdo(self, sending: Sending, now_ns: int) -> None:
        sending.sent(now_ns)
        self._post(sending.pdo.identifier, sending.pdo.packed(now_ns), now_ns)

    def _send_emergency(self, code: int, now_ns: int) -> None:
        data = code.to_bytes(2, "little") + bytes((self._register(),)) + bytes(5)
        self._post(_EMERGENCY + self._node, data, now_ns)

    def _register(self) -> int:
        register = 0
        for bits in self._errors.values():
            register |= bits
        return register

    def _post(self, identifier: int, data: bytes, now_ns: int) -> None:
        if "garbage" in self.faults:
            data = self._random.randbytes(len(data))
        self.post(CanFrame(identifier, data), now_ns + self._delay_ns())
