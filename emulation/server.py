"""The emulated robot served to other processes: its buses as terminals and sockets in one directory."""

import fcntl
import os
import stat
from contextlib import ExitStack
from pathlib import Path
from random import Random
from types import TracebackType
from typing import Any, Protocol

from echogrid.drivers.clock import Clock
from echogrid.emulation.buses.bus import Bus
from echogrid.emulation.buses.can_bus import CanBus
from echogrid.emulation.buses.i2c_bus import I2cBus
from echogrid.emulation.buses.iio_bus import IioBus
from echogrid.emulation.buses.serial_line import SerialLine
from echogrid.emulation.control import ControlServer, answer
from echogrid.emulation.errors import DirectoryError
from echogrid.emulation.robot import EmulatedRobot
from echogrid.emulation.wires.i2c_socket import I2cSocketWire
from echogrid.emulation.wires.iio_socket import IioSocketWire
from echogrid.emulation.wires.loop import Loop
from echogrid.emulation.wires.pty import SerialWire
from echogrid.emulation.wires.slcan import SlcanWire
from echogrid.emulation.wires.wire import Wire

CONTROL_SOCKET = "control.sock"
_LONGEST_WAIT_S = 0.1
"""How soon a stop is seen."""


class Flag(Protocol):
    """Says when to stop; a threading.Event is one."""

    def is_set(self) -> bool:
        """Whether it is time."""
        ...


def serve(robot: EmulatedRobot, directory: Path, clock: Clock, stop: Flag) -> None:
    """Serve until `stop` is set. Raises DirectoryError if another emulator lives there."""
    with Server(robot, directory, clock) as server:
        server.run(stop)


class Server:
    """An emulated robot in a directory: terminals `<bus>`, sockets `<bus>.sock` and the control socket.

    All are there after `with`; only `run` carries anything.
    """

    def __init__(self, robot: EmulatedRobot, directory: Path, clock: Clock) -> None:
        self._robot = robot
        self._directory = directory
        self._clock = clock
        self._loop = Loop()
        self._wires: list[Wire[Any, Any]] = []
        self._stack = ExitStack()

    def __enter__(self) -> "Server":
        """Take the directory, switch the robot on and bring its wires into being."""
        with ExitStack() as stack:
            stack.callback(self._loop.close)
            _own(self._directory, stack)
            self._robot.switch_on(self._clock.now_ns())
            for bus in self._robot.buses.values():
                wire = self._wire(bus)
                self._wires.append(wire)
                stack.callback(wire.close)
            self._pump()
            control = ControlServer(self._obey, self._directory / CONTROL_SOCKET, self._loop)
            stack.callback(control.close)
            self._stack = stack.pop_all()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """Take all of it away."""
        self._stack.close()

    def run(self, stop: Flag) -> None:
        """Run the robot in real time, in this thread, until `stop` is set."""
        while not stop.is_set():
            self._pump()
            due_s = (self._robot.next_event_ns() - self._clock.now_ns()) * 1e-9
            self._loop.wait(min(due_s, _LONGEST_WAIT_S))

    def _pump(self) -> None:
        for wire in self._wires:
            wire.pump()

    def _obey(self, message: object) -> dict[str, Any]:
        """Do what a control message says; before it is answered, ports have gone or come back."""
        reply = answer(self._robot, message, self._clock.now_ns())
        self._pump()
        return reply

    def _wire(self, bus: Bus[Any, Any]) -> Wire[Any, Any]:
        path = self._directory / bus.name
        match bus:
            case SerialLine():
                return SerialWire(bus, path, self._clock, self._loop, Random(bus.name))
            case CanBus():
                return SlcanWire(bus, path, self._clock, self._loop)
            case I2cBus():
                return I2cSocketWire(bus, path.with_name(f"{bus.name}.sock"), self._clock, self._loop)
            case IioBus():
                return IioSocketWire(bus, path.with_name(f"{bus.name}.sock"), self._clock, self._loop)
        raise DirectoryError(f"{bus.name}: no wire for this kind of bus")


def _own(directory: Path, stack: ExitStack) -> None:
    """Make the directory, lock it for as long as the stack lives, and remove what a dead emulator left."""
    try:
        directory.mkdir(mode=0o700, parents=True)
        stack.callback(_remove, directory)
    except FileExistsError:
        pass
    except OSError as error:
        raise DirectoryError(f"{directory}: cannot be made: {error.strerror}") from error
    try:
        descriptor = os.open(directory, os.O_RDONLY | os.O_DIRECTORY)
    except OSError as error:
        raise DirectoryError(f"{directory}: cannot be used: {error.strerror}") from error
    stack.callback(os.close, descriptor)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        raise DirectoryError(f"{directory}: another emulator lives here (stop it, or use another)") from error
    _sweep(directory)


def _sweep(directory: Path) -> None:
    """Remove terminals' links and sockets; leave anything else alone."""
    for entry in directory.iterdir():
        is_terminal = entry.is_symlink() and str(entry.readlink()).startswith("/dev/pts/")
        if is_terminal or stat.S_ISSOCK(entry.lstat().st_mode):
            entry.unlink()


def _remove(directory: Path) -> None:
    try:
        directory.rmdir()
    except OSError:  # Somebody keeps something of their own in it.
        return
