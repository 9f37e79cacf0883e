"""What every emulated ranger on I2C has: it ranges on command, and mostly is deaf to the bus meanwhile."""

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from random import Random
from typing import ClassVar

from echogrid.drivers.bus import NEVER_NS
from echogrid.emulation.devices.device import LOOKED_UP
from echogrid.emulation.devices.i2c_chip import I2cChip
from echogrid.emulation.devices.sonar import RANGING_VERBS, Sonar
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.faults import Verb
from echogrid.emulation.scene import Echo

_STORM = 0.7
"""Of the transfers in a storm so many are not acknowledged."""


class I2cRanger(I2cChip):
    """A chip with a sonar. A maker's own part: which bytes start a ranging, and which tell of it."""

    mute_while_ranging: ClassVar[bool] = True
    """Whether it takes no part in the bus while it ranges."""

    def __init__(self, name: str, address: int, surroundings: Surroundings, random: Random) -> None:
        super().__init__(name, address)
        self.sonar = Sonar(surroundings, self.faults, random)
        self._twin = random.randbytes(64)
        self._fired_ns = self._heard_ns = self._done_ns = NEVER_NS

    def acknowledges(self, now_ns: int) -> bool:
        """Whether it takes part in the bus: with power, on its wire, and not ranging."""
        if not self.has_contact(now_ns):
            return False
        if "nack_storm" in self.faults and self.sonar.random.random() < _STORM:
            return False
        return not (self.mute_while_ranging and self.ranging(now_ns))

    def ranging(self, now_ns: int) -> bool:
        """Whether a ranging is under way."""
        return self._fired_ns <= now_ns < self._done_ns

    def read(self, count: int) -> bytes:
        """So many bytes; those of a twin at the same address pull ones down to zeros."""
        data = self.sonar.random.randbytes(count) if "garbage" in self.faults else self._registers(count)
        if "address_conflict" in self.faults:
            return bytes(own & twin for own, twin in zip(data, self._twin, strict=False))
        return data

    def _verbs(self) -> Mapping[str, Verb]:
        return {
            **super()._verbs(),
            **RANGING_VERBS,
            "nack_storm": LOOKED_UP,
            "address_conflict": LOOKED_UP,
        }

    def _begin(self, now_ns: int, lasts_ns: int, listens_ns: int, silent: bool = False) -> None:
        """Fire now, listen for so long, and have done after `lasts_ns`."""
        self.sonar.fire(now_ns, silent)
        self._fired_ns = now_ns
        self._done_ns = now_ns + lasts_ns * self.sonar.slowness + self._delay_ns()
        self._heard_ns = min(now_ns + listens_ns, self._done_ns)

    def _power_up(self, now_ns: int) -> None:
        del now_ns
        self._reset()

    def _power_down(self) -> None:
        self._reset()

    def _reset(self) -> None:
        self._fired_ns = self._heard_ns = self._done_ns = NEVER_NS
        self._forget()

    def _next_ns(self) -> int:
        return self._heard_ns

    def _step(self, now_ns: int) -> None:
        if now_ns >= self._heard_ns:
            self._heard_ns = NEVER_NS
            self._hear(self.sonar.echoes())

    @abstractmethod
    def _registers(self, count: int) -> bytes:
        """So many bytes, as they are without a fault."""

    @abstractmethod
    def _hear(self, echoes: Sequence[Echo]) -> None:
        """Make of what was heard what will be read."""

    @abstractmethod
    def _forget(self) -> None:
        """Have all that is volatile at its default."""
