"""What the obstacle view costs: to make, beside its twin that goes cell by cell, and to publish."""

import socket
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import replace
from itertools import count
from math import cos, pi, sin, tau
from pathlib import Path
from tempfile import TemporaryDirectory

from tests.bench.stopwatch import REPEATS, Row, least_us
from tests.mapping import naive_sensor

from echogrid.mapping.footprint import Footprint
from echogrid.mapping.free_path import PathSensor, PathSight
from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.sonar_model import NoEcho
from echogrid.mapping.twist import Twist
from echogrid.mapping.unknown import Unknown
from echogrid.mapping.virtual_sensor import ObstacleView, Sight, VirtualSensor
from echogrid.runtime.outputs.beacon import Beacon
from echogrid.runtime.outputs.binary import datagram
from echogrid.runtime.outputs.datagrams import DatagramOutput, Format
from echogrid.runtime.outputs.json_line import line
from echogrid.runtime.outputs.pace import Pace
from echogrid.runtime.outputs.publisher import Output

SECOND = 1_000_000_000
NOW = 100 * SECOND
RESOLUTION, CELLS = 0.05, 120
BOX = Footprint.box(-0.16, 0.16, 0.18)
ROBOT = Pose(0.02, 0.01, 0.3)
TWISTS = {"straight ahead": Twist(0.5), "on an arc": Twist(0.5, 0.8), "on the spot": Twist(0.0, 1.0)}
TURNS = 200


def rows() -> Iterator[Row]:
    """What is measured."""
    local = seen()
    sensor = VirtualSensor(Sight(), RESOLUTION, CELLS)
    yield Row(
        "16 sectors of 120 x 120 cells",
        least_us(repeated(lambda: sensor.view(local, ROBOT, NOW))),
        "cell by cell",
        least_us(once(lambda: naive_sensor.sectors(local, ROBOT, NOW, 16, 2.0))),
    )
    yield Row("of which what is ahead, alone", least_us(repeated(lambda: sensor.ahead(local, ROBOT, NOW))))
    path = PathSensor(BOX, PathSight(unknown=Unknown.CLEAR), RESOLUTION, CELLS)
    for name, twist in TWISTS.items():
        times = [k * 0.05 / 0.5 for k in range(40)]  # 5 cm a step: much coarser than what it is beside
        yield Row(
            f"the free path {name}",
            least_us(repeated(lambda twist=twist: path.look(local, ROBOT, NOW, twist, 0.25))),
            "cell by cell, in steps of 5 cm",
            least_us(once(lambda twist=twist, t=times: naive_sensor.seconds(local, ROBOT, BOX, twist, t))),
        )
    yield Row("the free path of a twist that is new", least_us(fresh(path, local)))
    yield from published(sensor.view(local, ROBOT, NOW))


def seen() -> LocalGrid:
    """A grid after three rounds of a ring of 16 rangers in a room of 3.4 m x 3.4 m."""
    local = LocalGrid(RESOLUTION, CELLS, 0.1, 15.0, NoEcho.WEAK)
    local.centre(ROBOT)
    for k in range(48):
        angle = tau * k / 16.0
        distance = min(1.7 / max(abs(cos(angle)), abs(sin(angle)), 1e-9), 2.4)
        mount = Pose(0.15 * cos(angle), 0.15 * sin(angle), angle)
        local.fuse(mount, Ranger("ring", mount, pi / 12.0, 0.04, 2.5), distance - 0.15, NOW)
    return local


def published(view: ObstacleView) -> Iterator[Row]:
    """Each output by itself, as the loop meets it."""
    forms: dict[str, Format] = {"binary": datagram, "json": line}
    for name, form in forms.items():
        for there in (True, False):
            with ExitStack() as stack:
                address = str(Path(stack.enter_context(TemporaryDirectory())) / "out.sock")
                bound = stack.enter_context(socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM))
                if there:
                    bound.bind(address)
                output = DatagramOutput("bench", address, form, Pace(1000.0))
                stack.callback(output.close)
                who = "read at once" if there else "without a receiver"
                read = (lambda bound=bound: bound.recv(65536)) if there else None
                yield Row(f"a view by unix socket, {name}, {who}", least_us(told(output, view, read)))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as udp:
        udp.bind(("127.0.0.1", 0))
        output = DatagramOutput("bench", udp.getsockname(), datagram, Pace(1000.0))
        yield Row(
            "a view by UDP, binary, read at once", least_us(told(output, view, lambda: udp.recv(65536)))
        )
        output.close()
    yield Row("a view handed to a CAN bus", least_us(told(Beacon("bench", 0x300, Pace(1000.0)), view, None)))


def told(output: Output, view: ObstacleView, read: Callable[[], object] | None) -> Callable[[], int]:
    """Put one view after the other, and read each where somebody does."""
    views = (replace(view, stamp_ns=view.stamp_ns + k * SECOND) for k in count())
    due = [[next(views) for _ in range(TURNS)] for _ in range(REPEATS)][::-1]

    def work() -> int:
        for each in due.pop():
            output.put(each)
            if read is not None:
                read()
        return TURNS

    return work


def fresh(path: PathSensor, local: LocalGrid) -> Callable[[], int]:
    """Look along twists that were never looked along."""
    rates = iter(range(1, 1 << 30))

    def work() -> int:
        for _ in range(TURNS):
            path.look(local, ROBOT, NOW, Twist(0.5, 0.2 + next(rates) * 1e-6), 0.25)
        return TURNS

    return work


def repeated(work: Callable[[], object]) -> Callable[[], int]:
    """Many times."""

    def repeat() -> int:
        for _ in range(TURNS):
            work()
        return TURNS

    return repeat


def once(work: Callable[[], object]) -> Callable[[], int]:
    """One time: it is slow."""

    def single() -> int:
        work()
        return 1

    return single
