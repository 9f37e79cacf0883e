"""echogrid run: map, watch for obstacles and, if told to, drive; a robot, or an emulated one."""

import argparse
import json
import signal
import sys
from contextlib import ExitStack
from dataclasses import replace
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any

from echogrid.runtime.commands.arguments import add_directory, add_seed, add_theory, duration, finite

if TYPE_CHECKING:
    from echogrid.runtime.acquisition import DeviceReport
    from echogrid.runtime.commands.arguments import Commands
    from echogrid.runtime.config import Config
    from echogrid.runtime.console import Console
    from echogrid.runtime.log_writer import LogWriter
    from echogrid.runtime.modes.mode import Mode
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
    _add_modes(parser)
    add_theory(parser)
    add_directory(parser)
    add_seed(parser)
    parser.set_defaults(execute=execute)


def execute(arguments: argparse.Namespace) -> int:
    """Run; the exit code is 1 when a device was never read, or the goal was not reached."""
    from echogrid.runtime import robot_file
    from echogrid.runtime.console import Console
    from echogrid.runtime.emulated import DEFAULT_ROBOT
    from echogrid.runtime.modes import making

    source: Path = arguments.robot or DEFAULT_ROBOT
    config = robot_file.load(source)
    theory = arguments.theory or config.map.theory
    config = replace(config, map=replace(config.map, theory=theory))
    console = Console(sys.stderr)
    with ExitStack() as stack:
        with robot_file.located(source):
            mode = _mode(config, arguments, stack)
            config = making.brisk(config) if mode else config
            run = (_simulated if arguments.simulate else _live)(config, arguments, stack, console, mode)
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
    went_well = _ended(run, console)
    return 0 if written and went_well and not silent and _logged(log, arguments.log, console) else 1


def _add_modes(parser: argparse.ArgumentParser) -> None:
    """Say which ways of driving there are."""
    told = "at most one of these drives the robot (docs/drive-modes.md); without one it is only watched"
    group = parser.add_argument_group("drive modes", told)
    modes = group.add_mutually_exclusive_group()
    modes.add_argument(
        "--guard",
        metavar="SOURCE",
        help="pass on the safe part of what is wished for: unix:PATH, udp:[HOST:]PORT or joystick:DEVICE",
    )
    modes.add_argument(
        "--goto",
        nargs=2,
        type=finite,
        metavar=("X", "Y"),
        help="drive to this point, m, from where it starts: x ahead, y to the left; or on the --map",
    )
    modes.add_argument("--wander", action="store_true", help="drive wherever it is free (by --seed)")
    group.add_argument(
        "--map",
        type=Path,
        metavar="FILE",
        help="with --goto: find the way by this map, a map_server's YAML, or a folder with map.yaml",
    )
    group.add_argument(
        "--at",
        nargs=3,
        type=finite,
        metavar=("X", "Y", "YAW_DEG"),
        help="with --map: where on the map it starts (default: 0 0 0)",
    )


def _mode(config: "Config", arguments: argparse.Namespace, stack: ExitStack) -> "Mode | None":
    """What drives the robot, if anything does."""
    from echogrid.runtime.errors import UsageError
    from echogrid.runtime.modes import by_map, making, sources
    from echogrid.runtime.modes.guard import Guard

    _check_map_options(arguments)
    if arguments.map:
        return by_map.goto(config, arguments.map, arguments.goto, arguments.at or (0.0, 0.0, 0.0))
    if arguments.goto:
        return making.goto(config, *arguments.goto)
    if arguments.wander:
        return making.wander(config, arguments.seed)
    if arguments.guard is None:
        return None
    if arguments.simulate:
        raise UsageError(["--guard: nobody can wish in time on the clock of --simulate: leave that out"])
    wishes = sources.opened(arguments.guard, config.drive)
    stack.callback(wishes.close)
    return Guard(wishes)


def _check_map_options(arguments: argparse.Namespace) -> None:
    """Raises UsageError for a map that nothing would heed."""
    from echogrid.runtime.errors import UsageError

    if arguments.map and not arguments.goto:
        raise UsageError(["--map: only --goto X Y drives by a map: add that, or leave the map out"])
    if arguments.at and not arguments.map:
        raise UsageError(["--at: there is no map on which it could start: add --map FILE"])


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
    config: "Config",
    arguments: argparse.Namespace,
    _stack: ExitStack,
    _console: "Console",
    mode: "Mode | None",
) -> "Run":
    """The run on the jumping clock."""
    from echogrid.runtime.simulated_run import simulated_run

    return simulated_run(config, arguments.seed, mode=mode)[0]


def _live(
    config: "Config",
    arguments: argparse.Namespace,
    stack: ExitStack,
    console: "Console",
    mode: "Mode | None",
) -> "Run":
    """The run with its bus threads at work; with the emulated robot's if no other is given."""
    from echogrid.runtime.emulator_process import emulator
    from echogrid.runtime.live_run import live_run

    folder: Path = arguments.robot.parent if arguments.robot else arguments.dir
    if arguments.robot is None:
        stack.enter_context(emulator(folder, arguments.seed, driven=mode is not None))
        console.say(
            f"the emulated robot is in {folder}; to let a device fail: echogrid fault list --dir {folder}"
        )
    run, closed = stack.enter_context(live_run(config, folder, mode))
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


def _ended(run: "Run", console: "Console") -> bool:
    """Whether the mode, if one drove, ended as it should, or not by itself."""
    end = run.voyage.end if run.voyage else None
    if end:
        console.say(end.told)
    return end is None or end.reached


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
