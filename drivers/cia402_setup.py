"""How a drive (CiA 402) is set up to send its position: it is looked at first, then told by SDO."""

from echogrid.drivers import canopen_pdo
from echogrid.drivers.bus import NEVER_NS, CanFrame
from echogrid.drivers.canopen import mapping
from echogrid.drivers.canopen_pdo import BY_EVENT, EACH_SYNC, Pdo
from echogrid.drivers.cia402_settings import Cia402Settings
from echogrid.drivers.device import State
from echogrid.drivers.sdo import SdoRead, SdoWrite
from echogrid.drivers.sdo_course import SdoCourse, SdoPilot, do_all

DEVICE_TYPE, PRODUCER_TIME = 0x1000, 0x1017
STATUS = mapping(0x6041, 0, 16)
POSITION = mapping(0x6064, 0, 32)
VELOCITY = mapping(0x606C, 0, 32)
PROFILE = 402
"""In the lower half of the device type."""

STATUS_INHIBIT_MS, STATUS_EVENT_MS = 10, 100
"""Its state comes when it changes, and now and then."""
AGAIN_NS = 1_000_000_000
"""From a set-up that failed to the next attempt."""

Outcome = tuple[State, str]
"""WELL, or why the set-up failed."""


def requests(settings: Cia402Settings) -> tuple[SdoWrite, ...]:
    """What a drive is told; nothing of it concerns its motor."""
    status = Pdo(settings.status_tpdo, (STATUS,), BY_EVENT, STATUS_INHIBIT_MS, STATUS_EVENT_MS)
    motion_type = BY_EVENT if settings.sync == "off" else EACH_SYNC
    period_ms = settings.period_ms
    motion = Pdo(settings.tpdo, (POSITION, VELOCITY), motion_type, period_ms, period_ms)
    return (
        *canopen_pdo.transmit(settings.node, motion),
        *canopen_pdo.transmit(settings.node, status),
        SdoWrite(PRODUCER_TIME, 0, settings.heartbeat_ms.to_bytes(2, "little")),
    )


def set_up(settings: Cia402Settings) -> SdoCourse[Outcome]:
    """Look whether it is a drive, and tell it what to send."""
    answer = yield SdoRead(DEVICE_TYPE)
    if answer.reply is None:
        return State.MISSING, f"node {settings.node} is there, but does not reply to SDO requests"
    profile = int.from_bytes(answer.data[:2], "little")
    if not answer.trouble and profile != PROFILE:
        return (
            State.WRONG_DEVICE,
            f"the device profile of node {settings.node} (1000h) is {profile}, not 402: is node right? "
            "If it is a drive all the same, set configure = false",
        )
    if trouble := answer.trouble or (yield from do_all(requests(settings))):
        return (
            State.FAILED,
            f"its set-up stopped at {trouble}: choose other PDOs or times, let it be pre-operational, or set "
            "it up with its maker's tool and configure = false",
        )
    return State.WELL, ""


class SetUp:
    """Sets a drive up, again and again until that is done."""

    def __init__(self, settings: Cia402Settings) -> None:
        self.outcome: Outcome | None = None
        """What became of the latest attempt since it was begun anew; None: there was none."""
        self._settings = settings
        self._pilot = SdoPilot[Outcome](settings.node)
        self._again_ns = NEVER_NS
        self.begin(0)

    @property
    def done(self) -> bool:
        """Whether it sends what it should."""
        return self.outcome is not None and self.outcome[0] is State.WELL

    @property
    def deadline_ns(self) -> int:
        """When to step again."""
        return min(self._again_ns, self._pilot.deadline_ns)

    def begin(self, now_ns: int) -> None:
        """It may know nothing any more: begin anew."""
        self._pilot.stop()
        self.outcome = None
        self._again_ns = now_ns

    def take(self, data: bytes) -> bool:
        """Take a reply; whether it was waited for."""
        return self._pilot.take(data)

    def step(self, now_ns: int) -> tuple[CanFrame, ...]:
        """What is to be sent now."""
        if now_ns >= self._again_ns:
            self._again_ns = NEVER_NS
            self._pilot.start(set_up(self._settings))
        send = self._pilot.step(now_ns)
        if self._pilot.outcome is not None:
            self.outcome = self._pilot.outcome
            self._pilot.stop()
            self._again_ns = NEVER_NS if self.done else now_ns + AGAIN_NS
        return send
