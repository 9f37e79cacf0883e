"""The obstacle view as a binary datagram; docs/obstacle-sensor.md has the layout, byte by byte."""

from math import ceil
from struct import Struct
from zlib import crc32

from echogrid.mapping.free_path import PathEnd
from echogrid.mapping.unknown import Unknown
from echogrid.mapping.virtual_sensor import ObstacleView, Sector, SectorState
from echogrid.runtime.outputs.quantities import REASONS, bearing, millimetres, milliseconds

MAGIC = b"EGOV"
VERSION = 1
_HEADER = Struct("<4sBBBBIHHQIIfffffffB3x")
_SECTOR = Struct("<hHHBB")
_CHECK = Struct("<I")

_UNKNOWNS = {unknown: code for code, unknown in enumerate(Unknown)}
_ENDS = {end: code for code, end in enumerate(PathEnd)}
_STATES = {state: code for code, state in enumerate(SectorState)}
_STOP, _SILENT = 1, 2
_NONE_U32 = 0xFFFF_FFFF


def datagram(view: ObstacleView, sequence: int) -> bytes:
    """Little-endian: header, sectors, CRC-32. Ways are rounded down and ages up."""
    path, allowed = view.path, view.allowed
    header = _HEADER.pack(
        MAGIC,
        VERSION,
        (_STOP if view.stop else 0) | (_SILENT if view.silent else 0),
        REASONS[view.reason],
        _UNKNOWNS[view.unknown],
        sequence & _NONE_U32,
        _HEADER.size + _SECTOR.size * len(view.sectors) + _CHECK.size,
        len(view.sectors),
        view.stamp_ns,
        _microseconds(view.age_ns),
        _microseconds(view.latency_ns),
        view.speed_limit,
        path.distance,
        path.seconds,
        path.twist.speed,
        path.twist.turn_rate,
        allowed.speed,
        allowed.turn_rate,
        _ENDS[path.end],
    )
    body = header + b"".join(_sector(sector) for sector in view.sectors)
    return body + _CHECK.pack(crc32(body))


def _sector(sector: Sector) -> bytes:
    return _SECTOR.pack(
        bearing(sector.bearing),
        millimetres(sector.nearest),
        milliseconds(sector.age_ns),
        round(sector.confidence * 255.0),
        _STATES[sector.state],
    )


def _microseconds(age_ns: int | None) -> int:
    return _NONE_U32 if age_ns is None else min(ceil(age_ns / 1_000), _NONE_U32 - 1)
