"""The configured outputs, put together."""

from collections.abc import Iterator, Sequence
from pathlib import Path

from echogrid.runtime.config import Config
from echogrid.runtime.obstacle_config import OutputConfig
from echogrid.runtime.outputs.beacon import Beacon
from echogrid.runtime.outputs.binary import datagram
from echogrid.runtime.outputs.datagrams import Address, DatagramOutput
from echogrid.runtime.outputs.json_line import line
from echogrid.runtime.outputs.pace import Pace
from echogrid.runtime.outputs.publisher import Output

_FORMATS = {"binary": datagram, "json": line}


def outputs(config: Config, folder: Path) -> tuple[Output, ...]:
    """One for each [[output]]; relative paths start at `folder`."""
    return tuple(_made(each, folder) for each in config.output)


def beacons(config: Config, made: Sequence[Output]) -> Iterator[tuple[str, Beacon]]:
    """Those which are devices on a bus, with its name."""
    for each, output in zip(config.output, made, strict=True):
        if isinstance(output, Beacon) and each.bus is not None:
            yield each.bus, output


def _made(output: OutputConfig, folder: Path) -> Output:
    pace = Pace(output.rate_hz)
    if output.type == "can":
        return Beacon(output.label, output.id or 0, pace)
    address: Address = (output.host or "", output.port or 0)
    if output.type == "unix":
        address = str(folder / (output.path or ""))
    return DatagramOutput(output.label, address, _FORMATS[output.format], pace)
