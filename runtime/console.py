"""What a run shows in a terminal: a status line, changes of the devices' health, the account at the end."""

from collections.abc import Mapping
from shutil import get_terminal_size
from typing import TextIO

from echogrid.drivers.device import Health, Level
from echogrid.mapping.ledger import Ledger
from echogrid.runtime.acquisition import DeviceReport
from echogrid.runtime.fusion import Snapshot
from echogrid.runtime.loop import FixedRateLoop
from echogrid.runtime.status import Status


class Console:
    """Writes to a stream. On a terminal the status line stays in its place."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._in_place = stream.isatty()
        self._gone = False
        self._health: dict[str, Health] = {}
        self._restarts = 0
        self._slips = 0
        self._slipping = False

    def show(self, status: Status) -> None:
        """The status, after the changes since the last one."""
        self.show_changes(status)
        line = status.line()
        self._write(line[: get_terminal_size().columns - 1] if self._in_place else line + "\n")

    def show_changes(self, status: Status) -> None:
        """Only what has changed in the devices' health, and the odometry's."""
        for each in status.devices:
            self._tell_change(each)
        if status.snapshot.restarts > self._restarts:
            self._restarts = status.snapshot.restarts
            self.say(
                "odometry: a wheel restarted: where the robot went meanwhile is lost, the map may be bent"
            )

        self._tell_slip(status.snapshot)

    def say(self, line: str) -> None:
        """A line of its own."""
        self._write(f"{line}\n")

    def _write(self, text: str) -> None:
        """A run goes on when its terminal has gone."""
        if self._gone:
            return
        start = "\r\x1b[K" if self._in_place else ""
        try:
            self._stream.write(start + text)
            self._stream.flush()
        except OSError:
            self._gone = True

    def _tell_change(self, each: DeviceReport) -> None:
        """Trouble, and its end; what is well from the start is not news."""
        before = self._health.get(each.device)
        self._health[each.device] = each.health
        was = before.level if before else Level.OK
        if each.health.level is not was:
            self.say(f"{each.device}: {each.health.level.name}: {each.health.message}")

    def _tell_slip(self, snapshot: Snapshot) -> None:
        """Its beginning, also of one that is over already, and its end."""
        if snapshot.slips > self._slips:
            self.say("odometry: wheels slip: wheels and gyro disagree, the gyro's turn is taken")
        elif self._slipping and not snapshot.slipping:
            self.say("odometry: wheels and gyro agree again")
        self._slips, self._slipping = snapshot.slips, snapshot.slipping


def account_lines(
    ledger: Ledger,
    waiting: int,
    loop: FixedRateLoop,
    readings: Mapping[str, int],
    devices: list[DeviceReport],
) -> list[str]:
    """How it went, for a person."""
    due = loop.in_time + loop.late + loop.skipped
    dropped = ", ".join(f"{reason} {count}" for reason, count in sorted(ledger.dropped.items()))
    width = max((len(each.device) for each in devices), default=0)
    return [
        *(
            f"  {each.device:{width}}  {readings.get(each.device, 0):6d} readings  "
            f"{each.health.level.name}: {each.health.message}"
            for each in devices
        ),
        f"ticks: {loop.in_time} of {due} in time ({100.0 * loop.punctuality:.2f} %), {loop.late} late, "
        f"{loop.skipped} skipped, the worst {loop.worst_ns * 1e-6:.1f} ms after its deadline",
        f"range readings: {ledger.produced} = {ledger.fused} fused + {ledger.dropped.total()} dropped "
        f"({dropped or 'none'}) + {waiting} waiting",
    ]
