import os
import pty
from collections import Counter
from io import StringIO

from echogrid.drivers.device import Health, State
from echogrid.mapping.ledger import Ledger
from echogrid.runtime.acquisition import DeviceReport
from echogrid.runtime.console import Console, account_lines
from echogrid.runtime.loop import FixedRateLoop
from echogrid.runtime.status import Meter, Status

from .fakes import SECOND, HandClock
from .test_fusion import fusion


def status(*states: State) -> Status:
    devices = [
        DeviceReport(f"d{index}", "bus", Health(state, f"it is {state.level.name}", {}))
        for index, state in enumerate(states)
    ]
    snapshot = fusion().tick(2 * SECOND, [])
    return Meter(SECOND).look(snapshot, FixedRateLoop(HandClock(), 50.0), devices)


def test_trouble_is_told_once_and_so_is_its_end() -> None:
    stream = StringIO()
    console = Console(stream)
    for state in (State.WELL, State.SILENT, State.SILENT, State.WELL):
        console.show(status(state))
    told = [line for line in stream.getvalue().splitlines() if line.startswith("d0")]
    assert told == ["d0: STALE: it is STALE", "d0: OK: it is OK"]


def test_ailing_devices_are_named_in_the_status() -> None:
    line = status(State.WELL, State.MISSING, State.SILENT).line()
    assert "  1/3 ok: d1, d2  " in line
    assert "STOP" in line


def test_on_a_terminal_the_status_stays_in_its_line() -> None:
    master, slave = pty.openpty()
    with os.fdopen(slave, "w") as terminal:
        console = Console(terminal)
        console.show(status(State.WELL))
        console.say("hello")
        seen = ""
        while not seen.endswith("hello\r\n"):  # What is written does not pass all at once.
            seen += os.read(master, 4096).decode()
    os.close(master)
    assert seen.startswith("\r\x1b[K")
    assert seen.endswith("\r\x1b[Khello\r\n")
    assert seen.count("\n") == 1


def test_a_terminal_that_has_gone_does_not_stop_a_run() -> None:
    master, slave = pty.openpty()
    terminal = os.fdopen(slave, "w")
    console = Console(terminal)
    os.close(master)
    console.say("hello")
    console.show(status(State.WELL))
    os.dup2(os.open(os.devnull, os.O_WRONLY), slave)
    terminal.close()


def test_the_account_says_what_became_of_ticks_and_readings() -> None:
    ledger = Ledger(Counter({"echo": 5}), 2, Counter({"late": 1, "invalid": 1}))
    loop = FixedRateLoop(HandClock(), 50.0, in_time=98, late=1, skipped=1, worst_ns=3_000_000)
    devices = [DeviceReport("front", "bus", Health(State.WELL, "ranging", {}))]
    assert account_lines(ledger, 1, loop, {"front": 5}, devices) == [
        "  front       5 readings  OK: ranging",
        "ticks: 98 of 100 in time (98.00 %), 1 late, 1 skipped, the worst 3.0 ms after its deadline",
        "range readings: 5 = 2 fused + 2 dropped (invalid 1, late 1) + 1 waiting",
    ]
