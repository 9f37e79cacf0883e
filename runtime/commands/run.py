"""echogrid run: map and watch for obstacles, with a robot's devices or an emulated robot's."""

import argparse
import json
import signal
import sys
from contextlib import ExitStack
from dataclasses import replace
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any

from echogrid.runtime.commands.arguments import add_directory, add_seed, add_theory, duration

if TYPE_CHECKING:
    from echogrid.runtime.acquisition import DeviceReport
    from echogrid.runtime.commands.arguments import Commands
    from echogrid.runtime.config import Config
    from echogrid.runtime.console import Console
    from echogrid.runtime.log_writer import LogWriter
    from echogrid.runtime.service import Run

_SIMULATED_S = 60.0


def add(commands: "Commands") -> None:
    """Say what it takes."""
    parser = commands.add_parser("run", help="map and watch for obstacles", description=__doc__)
    parser.add_argument(
        "robot", type=Path, nargs="?", metavar="robot.toml", help="which robot (default: the emulated one)"
    )
    parser.add_argument(
        "--duration", type=duration, metavar="TIME", help="such as 60s (default: until Ctrl-C; simulated 60s)"
    )
    parser.add_argument("--log", type=Path, metavar="DIR", help="write the readings there")
    parser.add_argument(
        "--out", type=Path, default=Path("out"), metavar="DIR", help="where the map goes (default: out)"
    )
    parser.add_argument("--simulate", action="store_true", help="emulate all of it on a clock that jumps")
    add_theory(parser)
    add_directory(parser)
    add_seed(parser)
    parser.set_defaults(execute=execute)


def execute(arguments: argparse.Namespace) -> int:
    """Run; the exit code is 1 when a device was never read."""
    from echogrid.runtime import robot_file
    from echogrid.runtime.console import Console
    from echogrid.runtime.emulated import DEFAULT_ROBOT

    source: Path = arguments.robot or DEFAULT_ROBOT
    config = robot_file.load(source)
    theory = arguments.theory or config.map.theory
    config = replace(config, map=replace(config.map, theory=theory))
    console = Console(sys.stderr)
    with ExitStack() as stack:
        with robot_file.located(source):
            begin = _simulated if arguments.simulate else _live
            run = begin(config, arguments, stack, console)
        arguments.out.mkdir(parents=True, exist_ok=True)
        log = _log(arguments, source, config, stack)
        run.sinks = (log,) if log else ()
        _stop_on_signals(run)
        _go(run, arguments.duration or (_SIMULATED_S if arguments.simulate else None), console)
        devices = run.devices(run.clock.now_ns())
    _account(run, devices, console)
    silent = _silent(run, devices, console)
    report = {"theory": theory, **run.report(devices)}
    written = _write(run, report, arguments.out, console)
    return 0 if written and not silent and _logged(log, arguments.log, console) else 1


def _go(run: "Run", duration_s: float | None, console: "Console") -> None:
    """Let it run, and tell how it goes: the terminal or, where there is one, the service manager, which is
    told that the run is ready when it has turned for a second."""
    from echogrid.runtime.notify import ServiceManager
    from echogrid.runtime.status import Status

    manager = ServiceManager.of()
    looks = count()

    def show(status: Status) -> None:
        if next(looks) == 0:
            manager.ready()
        manager.alive(status.line())
        if manager.listens:
            console.show_changes(status)
        else:
            console.show(status)

    run.go(duration_s, show)
    manager.stopping()


def _simulated(
    config: "Config", arguments: argparse.Namespace, _stack: ExitStack, _console: "Console"
) -> "Run":
    """The run on the jumping clock."""
    from echogrid.runtime.simulated_run import simulated_run

    return simulated_run(config, arguments.seed)[0]


def _live(config: "Config", arguments: argparse.Namespace, stack: ExitStack, console: "Console") -> "Run":
    """The run with its bus threads at work; with the emulated robot's if no other is given."""
    from echogrid.runtime.emulator_process import emulator
    from echogrid.runtime.live_run import live_run

    folder: Path = arguments.robot.parent if arguments.robot else arguments.dir
    if arguments.robot is None:
        stack.enter_context(emulator(folder, arguments.seed))
        console.say(
            f"the emulated robot is in {folder}; to let a device fail: echogrid fault list --dir {folder}"
        )
    run, closed = stack.enter_context(live_run(config, folder))
    for trouble in closed:
        console.say(trouble)
    return run


def _log(
    arguments: argparse.Namespace, source: Path, config: "Config", stack: ExitStack
) -> "LogWriter | None":
    from echogrid.runtime import map_files
    from echogrid.runtime.log_writer import LogWriter

    if arguments.log is None:
        return None
    text = source.read_text(encoding="utf-8")
    log = stack.enter_context(LogWriter(arguments.log, text, bool(config.gyro), config.robot.wheels))
    if config.map.model_file:
        model = Path(config.map.model_file)
        map_files.replace(arguments.log / model.name, model.read_bytes())
    return log


def _stop_on_signals(run: "Run") -> None:
    """Ctrl-C, a service manager's stop and a closed terminal end the run after the tick under way."""

    def stop(*_: object) -> None:
        run.stopping = True

    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, stop)


def _account(run: "Run", devices: "list[DeviceReport]", console: "Console") -> None:
    from echogrid.runtime.console import account_lines

    for line in account_lines(run.fusion.ledger, run.fusion.waiting, run.loop, run.readings, devices):
        console.say(line)
    console.say(f"driven: {run.travelled:.1f} m")


def _silent(run: "Run", devices: "list[DeviceReport]", console: "Console") -> bool:
    """Whether a device was never read."""
    senders = {output.name for output in run.publisher.outputs}
    unread = [each.device for each in devices if not run.readings[each.device]]
    silent = [name for name in unread if name not in senders]
    if silent:
        console.say(f"never read: {', '.join(silent)}")
    return bool(silent)


def _write(run: "Run", report: dict[str, Any], folder: Path, console: "Console") -> bool:
    """Whether the map and the report could be written."""
    from echogrid.runtime import map_files

    try:
        map_files.write(folder, run.fusion.map_image(), run.path)
        map_files.replace(folder / "report.json", (json.dumps(report, indent=2) + "\n").encode())
    except OSError as error:
        console.say(f"{error.filename}: {error.strerror}: the map is not complete")
        return False
    print(f"map: {folder}/map.yaml map.pgm map.png map.npz, path: trajectory.tum, books: report.json")
    return True


def _logged(log: "LogWriter | None", folder: Path, console: "Console") -> bool:
    """Whether the log, if one was asked for, is whole."""
    if log is None or not log.lost:
        return True
    console.say(f"{folder}: {log.lost} rows could not be written: {log.trouble}")
    return False
