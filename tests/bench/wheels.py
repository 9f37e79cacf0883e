"""Four wheels on a CAN bus, read as the service reads them: by a port, a pump and a thread of their own."""

import os
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import replace
from random import Random
from typing import Any

import can
from tests.bench.drivers import adapter
from tests.bench.stopwatch import Load

from echogrid.drivers import registry
from echogrid.drivers.bus import CanFrame
from echogrid.drivers.clock import MonotonicClock
from echogrid.drivers.device import Line
from echogrid.drivers.readings import Reading
from echogrid.drivers.role import WheelRole
from echogrid.drivers.transports.can import CanPort
from echogrid.drivers.transports.slcan import line_of
from echogrid.emulation.buses.can_bus import CanBus
from echogrid.emulation.devices.can_node import CanNode
from echogrid.emulation.devices.shaft import Shaft
from echogrid.emulation.models import WHEELS
from echogrid.runtime.pump import Pump

SECOND_NS = 1_000_000_000
LASTS_NS = 3 * SECOND_NS
BATCH_NS = 10_000_000
REPEATS = 3
NODES = (1, 2, 3, 4)
CHANNEL = "bench"
BIT_RATE = 500_000
AXES: Mapping[str, tuple[str, Mapping[str, Any]]] = {
    "odrive-0.5": ("estimates at 100 Hz, heartbeats at 10 Hz", {}),
    "vesc": (
        "STATUS_5 at 100 Hz, STATUS and STATUS_4 at 10 Hz",
        {
            "messages": 0b010000,
            "period_ns": 10_000_000,
            "slow_messages": 0b001001,
            "slow_period_ns": 100_000_000,
        },
    ),
}

Send = Callable[[CanFrame], None]
OnWire = Callable[[], AbstractContextManager[tuple[CanPort, Send]]]


def rows() -> Iterator[Load]:
    """What is measured."""
    for driver, (messages, _) in AXES.items():
        frames = spoken(driver)
        for interface, on_wire in (("virtual", on_virtual), ("slcan", on_slcan)):
            yield Load(
                f"four {driver} on {interface}: {messages}",
                len(frames) * SECOND_NS // LASTS_NS,
                min(listened(driver, frames, on_wire) for _ in range(REPEATS)),
                min(listened(driver, batched(frames), on_wire) for _ in range(REPEATS)),
            )


def spoken(driver: str) -> list[CanFrame]:
    """What four emulated controllers say, stamped from 0 on."""
    bus = CanBus("bus", BIT_RATE, [_node(driver, node) for node in NODES])
    bus.switch_on(0)
    bus.take(SECOND_NS)
    frames = bus.take(SECOND_NS + LASTS_NS)
    return [replace(frame, stamp_ns=frame.stamp_ns - SECOND_NS) for frame in frames]


def _node(driver: str, node: int) -> CanNode:
    shaft = Shaft(lambda now_ns: 3.0 * now_ns * 1e-9)
    made = WHEELS[driver].build(f"axis {node}", shaft, Random(node), {"node": node, **AXES[driver][1]})
    assert isinstance(made, CanNode)
    return made


def batched(frames: Sequence[CanFrame]) -> list[CanFrame]:
    """The same in one go each 10 ms."""
    return [replace(frame, stamp_ns=frame.stamp_ns // BATCH_NS * BATCH_NS) for frame in frames]


def listened(driver: str, frames: Sequence[CanFrame], on_wire: OnWire) -> float:
    """Percent of a core that the reading thread needs while they come, each at its time, sent by another."""
    made = registry.driver(driver)
    line = Line("bench", [made(WheelRole(f"{node}"), made.Settings(node=node)) for node in NODES])
    readings: list[Reading] = []
    with on_wire() as (port, send):
        pump = Pump(line, port, MonotonicClock(), readings.extend)
        pump.turn()
        spent_s = _read_meanwhile(pump, lambda: _say(frames, send))
        pump.close()
    assert len(readings) > LASTS_NS // BATCH_NS * len(NODES) * 0.85
    return spent_s / (LASTS_NS * 1e-9) * 100


def _say(frames: Sequence[CanFrame], send: Send) -> None:
    began_ns = time.monotonic_ns()
    for frame in frames:
        time.sleep(max(began_ns + frame.stamp_ns - time.monotonic_ns(), 0) * 1e-9)
        send(frame)


def _read_meanwhile(pump: Pump[Any, Any], work: Callable[[], None]) -> float:
    """Seconds that the thread which turns the pump was busy, while this one works."""
    done, spent_s = threading.Event(), [0.0]

    def read() -> None:
        before_s = time.thread_time()
        while not done.is_set():
            pump.turn()
        spent_s[0] = time.thread_time() - before_s

    thread = threading.Thread(target=read)
    thread.start()
    work()
    done.set()
    thread.join()
    return spent_s[0]


@contextmanager
def on_virtual() -> Iterator[tuple[CanPort, Send]]:
    """A port on python-can's virtual bus, and what sends to it."""
    with can.Bus(CHANNEL, "virtual", ignore_config=True) as bus:

        def send(frame: CanFrame) -> None:
            bus.send(
                can.Message(arbitration_id=frame.identifier, data=frame.data, is_extended_id=frame.extended)
            )

        yield CanPort(CHANNEL, interface="virtual"), send


@contextmanager
def on_slcan() -> Iterator[tuple[CanPort, Send]]:
    """A port on a pty, at whose other end is an adapter."""
    with adapter() as (master, path):
        yield CanPort(path, interface="slcan"), lambda frame: _write(master, frame)


def _write(master: int, frame: CanFrame) -> None:
    os.write(master, line_of(frame))
