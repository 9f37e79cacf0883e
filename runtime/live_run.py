"""A run on real ports and the real clock."""

import gc
import sys
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

from echogrid.drivers.clock import MonotonicClock
from echogrid.drivers.errors import PortError
from echogrid.runtime import outlets
from echogrid.runtime.acquisition import ThreadedAcquisition
from echogrid.runtime.config import Config
from echogrid.runtime.loop import FixedRateLoop
from echogrid.runtime.modes.mode import Mode
from echogrid.runtime.outputs.publisher import Publisher
from echogrid.runtime.ports import real_ports
from echogrid.runtime.pump import PortState, Pump
from echogrid.runtime.reading_queue import ReadingQueue
from echogrid.runtime.service import Run
from echogrid.runtime.voyage import commissioned

_SWITCH_INTERVAL_S = 1e-4
"""How long a bus thread may keep the interpreter from the loop."""


@contextmanager
def live_run(config: Config, folder: Path, mode: Mode | None = None) -> Iterator[tuple[Run, list[str]]]:
    """The run, ready to go with its bus threads at work, and what is wrong with ports that did not open.
    It drives if there is a mode.

    Those are tried again for as long as the run lasts. Raises ConfigError for a wrong configuration, and
    PortError if not one port opens.
    """
    clock = MonotonicClock()
    queue = ReadingQueue()
    made = outlets.outputs(config, folder)
    lines, fusion, voyage = commissioned(config, mode, tuple(outlets.beacons(config, made)))
    ports = real_ports(config, lines, folder)
    pumps = [Pump(line, ports[line.name], clock, queue.put) for line in lines]
    for pump in pumps:
        pump.turn()
    closed = list(_closed(pumps))
    if len(closed) == len(pumps):
        raise PortError("\n".join([*closed, "no port could be opened"]))
    publisher = Publisher(made)
    with closing(publisher), quick_threads(), ThreadedAcquisition(pumps, queue) as acquisition:
        loop = FixedRateLoop(clock, config.loop.rate_hz)
        yield Run(fusion, loop, acquisition, clock, publisher=publisher, voyage=voyage), closed


@contextmanager
def quick_threads() -> Iterator[None]:
    """Keep the loop from waiting: for a bus thread's turn, or for what is there to stay to be collected."""
    before_s = sys.getswitchinterval()
    sys.setswitchinterval(_SWITCH_INTERVAL_S)
    gc.collect()
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()
        sys.setswitchinterval(before_s)


def _closed(pumps: Sequence[Pump[Any, Any]]) -> Iterator[str]:
    for pump in pumps:
        if pump.state is PortState.CLOSED:
            devices = ", ".join(device.name for device in pump.line.devices)
            yield f"{devices}: {pump.trouble}"
