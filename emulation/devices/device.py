"""What every emulated device has: a supply, a plug, faults, and a way to be run up to a time."""

from abc import abstractmethod
from collections.abc import Mapping
from zlib import crc32

from echogrid.emulation.faults import Fallible, Verb

DELAY_NS = 200_000_000
"""How late a delayed device is."""
_SPELL_NS = 300_000_000
"""A bad contact is good or bad for so long at a time."""


def _nothing(now_ns: int) -> None:
    """Change nothing."""
    del now_ns


LOOKED_UP = Verb(_nothing, _nothing)
"""A fault for which the device looks when it makes its output."""


class EmulatedDevice(Fallible):
    """One device, run by its bus: `advance` does what is due, `next_event_ns` says when to call again.

    It begins without power. Nothing in it waits: on a jumping clock and on the machine's own it is the same.
    """

    def __init__(self, name: str) -> None:
        super().__init__(name, self._verbs())
        self.connected = True
        self.unplugs = 0
        """How often its plug was pulled."""
        self._outages: set[str] = {"not yet switched on"}

    def switch_on(self, now_ns: int) -> None:
        """Give it power for the first time."""
        self.restore_power("not yet switched on", now_ns)

    @property
    def powered(self) -> bool:
        """Whether nothing keeps its supply off."""
        return not self._outages

    def has_contact(self, now_ns: int) -> bool:
        """Whether it has power and its wire; a bad contact comes and goes by chance."""
        if not (self.powered and self.connected):
            return False
        return "intermittent" not in self.faults or bool(
            crc32(f"{self.name}/{now_ns // _SPELL_NS}".encode()) & 1
        )

    def lose_power(self, cause: str, now_ns: int) -> None:
        """Take its supply; several causes may at once."""
        del now_ns
        was_powered = self.powered
        self._outages.add(cause)
        if was_powered:
            self._power_down()
            self.on_change()

    def restore_power(self, cause: str, now_ns: int) -> None:
        """End one cause; it powers up when the last one ends."""
        was_powered = self.powered
        self._outages.discard(cause)
        if self.powered and not was_powered:
            self._power_up(now_ns)
            self.on_change()

    def switch_off(self, now_ns: int) -> None:
        """Fault `off`: it has no power, and is silent."""
        self.lose_power("off", now_ns)

    def switch_on_again(self, now_ns: int) -> None:
        """The end of `off`."""
        self.restore_power("off", now_ns)

    def unplug(self, now_ns: int) -> None:
        """Fault `unplug`: its wire and its power are gone."""
        self.connected = False
        self.unplugs += 1
        self.lose_power("unplug", now_ns)

    def plug_in(self, now_ns: int) -> None:
        """The end of `unplug`."""
        self.connected = True
        self.restore_power("unplug", now_ns)

    def _verbs(self) -> Mapping[str, Verb]:
        """Its faults by name; a device adds its own."""
        return {
            "off": Verb(self.switch_off, self.switch_on_again),
            "unplug": Verb(self.unplug, self.plug_in),
            "garbage": LOOKED_UP,
            "delayed": LOOKED_UP,
            "intermittent": LOOKED_UP,
        }

    def _delay_ns(self) -> int:
        return DELAY_NS if "delayed" in self.faults else 0

    @abstractmethod
    def _power_up(self, now_ns: int) -> None:
        """Start afresh: all that is volatile is at its default."""

    @abstractmethod
    def _power_down(self) -> None:
        """Fall silent in the middle of anything."""
