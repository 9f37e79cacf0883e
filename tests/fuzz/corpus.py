"""What a driver and its emulated device say to each other: true words, to be bent and mixed with noise."""

from collections.abc import Iterator
from random import Random
from typing import Any

from echogrid.drivers import registry
from echogrid.drivers.bus import Break
from echogrid.drivers.device import BusLine, Step
from echogrid.drivers.role import RangerRole, Slot
from echogrid.emulation.buses.serial_line import SerialLine
from echogrid.emulation.devices.serial_device import SerialDevice
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.models import RANGERS
from echogrid.emulation.scene import Echo

MS = 1_000_000
START_NS = 10_000 * MS
SPEED = 343.2

_LASTS_NS = 15_000 * MS
_PAUSE_NS = 5 * MS
"""So much silence parts two messages."""

Request = tuple[bytes | Break, ...]
Words = dict[Request, list[bytes]]
"""What a device says, by what it is asked."""
UNASKED: Request = ()
"""To those which send by themselves."""


def subject(name: str) -> tuple[BusLine[Any, Any], RangerRole]:
    """A line with a device of that driver, which is asked for as much reach as it has; and its role."""
    driver = registry.driver(name)
    for farthest in (4.0, 1.0):
        role = RangerRole(name, 0.05, farthest, Slot(100 * MS, 0), SPEED)
        try:
            return driver.line("line", [driver(role, driver.Settings())]), role
        except ValueError:
            continue
    raise ValueError(f"{name} does not even reach 1 m")


def emulated(name: str, seed: int) -> SerialLine:
    """A line with the emulated device of that driver, switched on at START_NS."""
    device = RANGERS[name].build(name, Surroundings(_scene, SPEED), Random(seed), {})
    assert isinstance(device, SerialDevice)
    wire = SerialLine("line", device)
    wire.switch_on(START_NS)
    return wire


def conversed(
    line: BusLine[Any, Any], wire: SerialLine, from_ns: int, until_ns: int
) -> Iterator[tuple[int, bytes, Step[Any]]]:
    """Let them talk: each time, what came then, and the driver's step."""
    now_ns = from_ns
    while now_ns < until_ns:
        received = wire.take(now_ns)
        step = line.step(now_ns, received)
        yield now_ns, b"".join(received), step
        if step.send:
            wire.send(step.send, now_ns)
        now_ns = max(now_ns + 1, min(step.deadline_ns, wire.next_event_ns()))


def recorded(name: str, seed: int) -> Words:
    """What the emulated device of that driver says within some seconds."""
    said: dict[Request, list[bytearray]] = {UNASKED: []}
    request, ended_ns, (line, _) = UNASKED, START_NS, subject(name)
    for now_ns, data, step in conversed(line, emulated(name, seed), START_NS, START_NS + _LASTS_NS):
        if data:
            if request == UNASKED and now_ns - ended_ns > _PAUSE_NS:
                said[request].append(bytearray())
            said[request][-1] += data
            ended_ns = now_ns
        if step.send:
            request = tuple(step.send)
            said.setdefault(request, []).append(bytearray())
    words = {request: [bytes(word) for word in told if word] for request, told in said.items()}
    return {request: told for request, told in words.items() if told}


def _scene(fire_ns: int) -> tuple[Echo, ...]:
    """A wall which is elsewhere each time, and sometimes nowhere."""
    place = fire_ns // (50 * MS) % 41
    return (Echo(0.3 + 0.09 * place, 40.0, "wall"),) if place else ()
