"""An emulated robot before a wall, served on real ports by a thread."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from echogrid.drivers.clock import MonotonicClock
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.robot import BusSpec, EmulatedRobot, RangerSpec, RobotSpec
from echogrid.emulation.scene import Echo
from echogrid.emulation.server import Server

SPEED = 343.21


@contextmanager
def served(folder: Path, buses: dict[str, str], rangers: list[RangerSpec], distance: float) -> Iterator[None]:
    """Rangers on buses (name and kind); all see a wall at that distance (m), while the context lasts."""
    wall = Surroundings(lambda fire_ns: (Echo(distance, 60.0, "wall"),), SPEED)
    specs = tuple(BusSpec(name, kind) for name, kind in buses.items())
    robot = EmulatedRobot(
        RobotSpec(0.1, 0.4, specs, tuple(rangers), ()), lambda _: wall, lambda _side: lambda _now: 0.0
    )
    stop = threading.Event()
    with Server(robot, folder, MonotonicClock()) as server:
        thread = threading.Thread(target=server.run, args=(stop,))
        thread.start()
        try:
            yield
        finally:
            stop.set()
            thread.join()
