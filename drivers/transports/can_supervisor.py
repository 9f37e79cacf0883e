"""A CAN bus watched over: its state by name, when to send and when not, and what is set up badly."""

from collections import Counter
from dataclasses import dataclass

from echogrid.drivers.device import State
from echogrid.drivers.transports.can_errors import error_classes, told_state
from echogrid.drivers.transports.can_link import FD_MTU, BusState, CanLink
from echogrid.drivers.transports.fd_rates import DATA_BITRATE, SAMPLE_POINT

LOOK_EVERY_NS = 500_000_000
SILENCE_NS = 1_000_000_000
BACK_OFF_NS = (100_000_000, 200_000_000, 500_000_000, 1_000_000_000)
KIND = "can"
"""What the kernel calls interfaces that have a controller."""
RESTART_MS = 100
"""What is advised."""
GARBLED_FROM = 10
"""Malformed lines between two looks, if they are more than the frames."""
WIRES = "check the wires, 120 ohm at both ends, and that all nodes have power and one bit rate"


@dataclass(frozen=True, slots=True)
class Condition:
    """How a bus is."""

    state: State
    message: str


class CanSupervisor:
    """Told by its port what happens. Knows no clock and asks nobody."""

    def __init__(self, name: str, bitrate: int, counts: Counter[str], fd: bool = False) -> None:
        """`bitrate` is what the robot's devices want, `fd` that they want CAN-FD; `counts` is where error
        frames are counted by class."""
        self._name = name
        self._bitrate = bitrate
        self._fd = fd
        self._counts = counts
        self._restart(0, None)

    def opened(self, now_ns: int, link: CanLink | None) -> None:
        """The port was opened; `link` is None where there is none, or it cannot be asked."""
        self._restart(now_ns, link)
        self._open = True

    def closed(self) -> None:
        """The port was closed: nothing is known any more, but what was counted."""
        self._open = False

    def _restart(self, now_ns: int, link: CanLink | None) -> None:
        self._open = False
        self._first = self.link = link
        self._state = link.state if link else None
        self._heard_ns = now_ns
        self._refusals = 0
        self._send_again_ns = 0
        self._frames = self._malformed = 0
        self._garbled = False
        self.look_ns = now_ns + LOOK_EVERY_NS

    def heard(self, now_ns: int, frames: int, malformed: int) -> None:
        """So many frames came, and so much that is none."""
        self._frames += frames
        self._malformed += malformed
        if frames:
            self._heard_ns = now_ns

    def erred(self, identifier: int, data: bytes) -> None:
        """An error frame of the kernel came."""
        self._counts.update(error_classes(identifier))
        self._state = told_state(identifier, data) or self._state

    def looked(self, now_ns: int, link: CanLink | None) -> str:
        """The link was looked at again: why the port can't be used any more; "" if it can."""
        self.look_ns = now_ns + LOOK_EVERY_NS
        self._garbled = self._malformed > max(self._frames, GARBLED_FROM)
        self._frames = self._malformed = 0
        if self._first is None:
            return ""
        if link is None or link.index != self._first.index:
            return f"{self._name}: CAN port lost, was it unplugged? (there is no such interface)"
        self.link = link
        self._state = link.state
        return "" if link.up else down(self._name, link, self._bitrate, self._fd)

    def sent(self) -> None:
        """All went out, or into the queue at least."""
        self._refusals = 0

    def refused(self, now_ns: int) -> None:
        """The queue was full: sending waits, each time a little longer."""
        self._send_again_ns = now_ns + BACK_OFF_NS[min(self._refusals, len(BACK_OFF_NS) - 1)]
        self._refusals += 1

    def may_send(self, now_ns: int) -> bool:
        """Whether frames have a chance."""
        return self._state is not BusState.BUS_OFF and (not self._refusals or now_ns >= self._send_again_ns)

    def link_counts(self) -> dict[str, int]:
        """What happened on the link since the port was opened, by name."""
        first, link = self._first, self.link  # its bus's thread may open the port again at any time
        if link is None or first is None:
            return {}
        before = first.counts
        counts = {f"link: {name}": now - before.get(name, 0) for name, now in link.counts.items()}
        if link.errors:
            counts["send error counter"], counts["receive error counter"] = link.errors
        return counts

    def condition(self, now_ns: int) -> Condition:
        """The worst that is known; if nothing is, WELL and what should be mended all the same."""
        name, state = self._name, self._state
        if not self._open:
            return Condition(State.WELL, "")
        if state is BusState.BUS_OFF:
            return Condition(State.BUS_OFF, f"{name}: bus-off, {self._after_bus_off()}; {WIRES}")
        if self._refusals:
            return Condition(
                State.CONGESTED,
                f"{name}: frames do not go out, nobody acknowledges them; {self._advised(WIRES)}",
            )
        if self._garbled:
            return Condition(
                State.GARBLED,
                f"{name}: lines without a meaning: does it speak slcan, at this speed, its time stamp off?",
            )
        if state is BusState.ERROR_PASSIVE:
            return Condition(State.ERROR_PASSIVE, f"{name}: error-passive; {self._advised(WIRES)}")
        if now_ns - self._heard_ns > SILENCE_NS:
            return Condition(State.SILENT, f"{name}: not a frame in 1 s; {self._advised(WIRES)}")
        return Condition(State.WELL, self._advised())

    def _after_bus_off(self) -> str:
        link = self.link
        if link is not None and link.restart_ms:
            return f"started again after {link.restart_ms} ms"
        return f"and it stays so: {self._set_up_again(link)} (without restart-ms if the adapter refuses it)"

    def _advised(self, first: str = "") -> str:
        """That, and all that is set up badly."""
        return "; ".join(filter(None, (first, *self._advice())))

    def _advice(self) -> list[str]:
        link, name = self.link, self._name
        if link is None or link.kind != KIND:
            return []
        advice = []
        if link.bitrate not in (None, self._bitrate):
            advice.append(
                f"{name} has {link.bitrate} bit/s, {self._bitrate} was asked for: "
                f"set bit_rate in robot.toml, or {self._set_up_again(None)}"
            )
        if self._fd and link.data_bitrate not in (None, DATA_BITRATE):
            advice.append(
                f"{name} has {link.data_bitrate} bit/s for the data of CAN-FD, not {DATA_BITRATE}: "
                f"{self._set_up_again(link)}"
            )
        if link.restart_ms == 0:
            advice.append(f"{name} does not come back after a bus-off: {self._set_up_again(link)}")
        if self.link_counts().get("link: overruns"):
            advice.append(f"{name} has lost frames on the way in: the machine or its adapter is too slow")
        return advice

    def _set_up_again(self, link: CanLink | None) -> str:
        """The line that does so: as the link is, or else as the devices want it."""
        name, bitrate = self._name, (link.bitrate if link else None) or self._bitrate
        # While it is up, neither bit rate nor restart-ms may be changed.
        return f"sudo ip link set {name} down && {set_up(name, bitrate, self._fd)}"


def down(name: str, link: CanLink, bitrate: int, fd: bool = False) -> str:
    """What to do about an interface that is down."""
    mend = set_up(name, link.bitrate or bitrate, fd) if link.kind == KIND else f"sudo ip link set {name} up"
    return f"{name}: this CAN interface is down ({mend})"


def classic(name: str, link: CanLink, bitrate: int) -> str:
    """What to do about an interface that takes no frames of CAN-FD."""
    fast = set_up(name, bitrate, fd=True) if link.kind == KIND else f"sudo ip link set {name} mtu {FD_MTU} up"
    return f"{name}: this CAN interface is set up without CAN-FD (sudo ip link set {name} down && {fast})"


def set_up(name: str, bitrate: int, fd: bool = False) -> str:
    """The line that sets an interface up which is down."""
    rates = f"bitrate {bitrate}"
    if fd:
        point = f"{SAMPLE_POINT / 100:.3f}"
        rates += f" sample-point {point} dbitrate {DATA_BITRATE} dsample-point {point} fd on"
    return f"sudo ip link set {name} up type can {rates} restart-ms {RESTART_MS}"
