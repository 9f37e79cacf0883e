"""What a drive (CiA 402) has said of itself, and for how long that holds."""

from collections.abc import Sequence
from struct import Struct

from echogrid.drivers import canopen
from echogrid.drivers.canopen import Emergency, NmtState
from echogrid.drivers.cia402_state import FAULTS, DriveState, drive_state
from echogrid.drivers.emergency import blinds, emergency_name, is_communication, is_reset

MISSED = 4
"""So many heartbeats that stay away mean that it is gone."""
STATUS_NS = 400_000_000
"""So long a status word is believed; it comes each 100 ms."""

STATUS = Struct("<H")


class DriveReport:
    """Its heartbeat, its status word, and the error that it has told last.

    Each is replaced as a whole: its bus's thread may lose the port while another one asks how it is.
    """

    def __init__(self, heartbeat_ms: int) -> None:
        self.patience_ns = MISSED * heartbeat_ms * 1_000_000
        self.heard_ns: int | None = None
        """When the latest frame of it came."""
        self.beat: tuple[int, int] | None = None
        """When the latest heartbeat came, and its network state."""
        self._status: tuple[int, DriveState | None] | None = None
        self._emergency: Emergency | None = None

    def forget(self) -> None:
        """The port was lost: what was heard counts no more."""
        self.heard_ns = self.beat = None
        self.restarted()

    def restarted(self) -> None:
        """It has started anew: what it said before is void."""
        self._status = self._emergency = None

    def told_status(self, stamp_ns: int, data: bytes) -> None:
        """The 2 bytes of 6041h have come."""
        self._status = stamp_ns, drive_state(*STATUS.unpack(data))

    def told_emergency(self, data: bytes) -> bool:
        """The 8 bytes of an EMCY have come; whether they tell an error."""
        emergency = canopen.decode_emergency(data)
        self._emergency = None if is_reset(emergency.code) else emergency
        return self._emergency is not None

    def heard(self, now_ns: int) -> bool:
        """Whether anything has come of it lately."""
        heard_ns = self.heard_ns
        return heard_ns is not None and now_ns - heard_ns <= self.patience_ns

    def alive(self, now_ns: int) -> bool:
        """Whether its heartbeat comes."""
        beat = self.beat
        return beat is not None and now_ns - beat[0] <= self.patience_ns

    def operational(self, now_ns: int) -> bool:
        """Whether its PDOs count."""
        beat = self.beat
        return beat is not None and beat[1] == NmtState.OPERATIONAL and now_ns - beat[0] <= self.patience_ns

    @property
    def network_state(self) -> str:
        """What its heartbeat said, in a word."""
        beat = self.beat
        return canopen.state_name(beat[1]) if beat else "not heard"

    def state(self, now_ns: int) -> DriveState | None:
        """What its status word says, if that is fresh."""
        status = self._status
        return status[1] if status is not None and now_ns - status[0] <= STATUS_NS else None

    @property
    def blind(self) -> bool:
        """Whether its encoder has failed."""
        emergency = self._emergency
        return emergency is not None and blinds(emergency.code)

    def fault(self, now_ns: int) -> str:
        """What is wrong with it; empty if nothing is. Trouble on the bus is no fault of it."""
        emergency = self._emergency
        if self.state(now_ns) in FAULTS:
            return f"in fault ({emergency_name(emergency.code) if emergency else 'its EMCY was not heard'})"
        if emergency is not None and not is_communication(emergency.code):
            return emergency_name(emergency.code)
        return ""

    def remarks(self, now_ns: int) -> Sequence[str]:
        """What else it says while it is well."""
        emergency, state = self._emergency, self.state(now_ns)
        remarks = [state.title] if state else []
        if emergency is not None:
            remarks.append(emergency_name(emergency.code))
        return remarks
