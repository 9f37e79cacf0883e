"""The control socket: faults by name, as one JSON object a line in either direction."""

import json
import socket
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from echogrid.drivers.bus import NEVER_NS
from echogrid.drivers.errors import EchogridError
from echogrid.emulation.errors import ControlError
from echogrid.emulation.faults import ActiveFault
from echogrid.emulation.robot import EmulatedRobot
from echogrid.emulation.wires.loop import Loop
from echogrid.emulation.wires.unix_socket import listen

_LONGEST_LINE = 65536
_USAGE = '{"fault": name, "verb": verb, "for_s": seconds or null}, {"clear": name} or {"list": true}'


def answer(robot: EmulatedRobot, message: object, now_ns: int) -> dict[str, Any]:
    """What to answer to a message, after doing what it says: {"ok": ...} or {"error": text}."""
    try:
        match message:
            case {"fault": str(name), "verb": str(verb), **rest}:
                robot.fault(name, verb, now_ns, _duration_ns(rest.get("for_s")))
                return {"ok": True}
            case {"clear": str(name)}:
                robot.clear(name, now_ns)
                return {"ok": True}
            case {"list": True}:
                active = [_shown(fault, now_ns) for fault in robot.active_faults(now_ns)]
                return {"ok": {"faults": active, "verbs": robot.verbs()}}
    except EchogridError as error:
        return {"error": str(error)}
    return {"error": f"not understood (one of: {_USAGE})"}


class ControlServer:
    """Answers any number of clients with what `do` makes of their messages."""

    def __init__(self, do: Callable[[object], dict[str, Any]], path: Path, loop: Loop) -> None:
        self._do = do
        self._path = path
        self._loop = loop
        self._clients: dict[socket.socket, bytearray] = {}
        self._listener = listen(path, socket.SOCK_STREAM)
        loop.watch(self._listener.fileno(), self._accept)

    def close(self) -> None:
        """Let go of all clients and remove the socket."""
        self._path.unlink(missing_ok=True)
        self._loop.unwatch(self._listener.fileno())
        self._listener.close()
        for client in tuple(self._clients):
            self._dismiss(client)

    def _accept(self) -> None:
        try:
            client, _ = self._listener.accept()
        except OSError:  # It has gone again.
            return
        client.setblocking(False)
        self._clients[client] = bytearray()
        self._loop.watch(client.fileno(), lambda: self._receive(client))

    def _receive(self, client: socket.socket) -> None:
        try:
            data = client.recv(_LONGEST_LINE)
        except OSError:
            data = b""
        buffer = self._clients[client]
        buffer += data
        *lines, rest = bytes(buffer).split(b"\n")
        buffer[:] = rest
        replies = b"".join(_line(self._answer(line)) for line in lines)
        if not data or len(rest) > _LONGEST_LINE or not _sent(client, replies):
            self._dismiss(client)

    def _answer(self, line: bytes) -> dict[str, Any]:
        try:
            message = json.loads(line)
        except ValueError as error:
            return {"error": f"not JSON: {error}"}
        return self._do(message)

    def _dismiss(self, client: socket.socket) -> None:
        del self._clients[client]
        self._loop.unwatch(client.fileno())
        client.close()


def request(path: Path, message: Mapping[str, object], timeout_s: float = 2.0) -> Any:
    """What the emulator says to a message, its "ok". Raises ControlError if it refuses or does not answer."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as client:
        client.settimeout(timeout_s)
        try:
            client.connect(str(path))
            client.sendall(_line(message))
            with client.makefile("rb") as stream:
                line = stream.readline()
        except (FileNotFoundError, ConnectionRefusedError) as error:
            raise ControlError(f"{path}: no emulator runs there: start one with: echogrid emulate") from error
        except OSError as error:
            raise ControlError(f"{path}: no answer: {error.strerror or error}") from error
    if not line:
        raise ControlError(f"{path}: the emulator has gone")
    reply = json.loads(line)
    if "error" in reply:
        raise ControlError(reply["error"])
    return reply["ok"]


def _duration_ns(for_s: object) -> int | None:
    if for_s is None:
        return None
    if isinstance(for_s, bool) or not isinstance(for_s, int | float) or not 0 < for_s < 1e9:
        raise ControlError(f"for_s: {for_s!r} is not a number of seconds above 0, or null")
    return round(for_s * 1e9)


def _shown(fault: ActiveFault, now_ns: int) -> dict[str, object]:
    left_s = None if fault.until_ns == NEVER_NS else (fault.until_ns - now_ns) / 1e9
    return {"name": fault.name, "verb": fault.verb, "for_s": left_s}


def _line(message: Mapping[str, object]) -> bytes:
    return json.dumps(message).encode() + b"\n"


def _sent(client: socket.socket, data: bytes) -> bool:
    try:
        client.sendall(data)
    except OSError:
        return False
    return True
