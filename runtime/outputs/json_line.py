"""The obstacle view as a line of JSON; docs/obstacle-sensor.md lists the keys."""

import json
from math import isinf

from echogrid.mapping.free_path import FreePath
from echogrid.mapping.twist import Twist
from echogrid.mapping.virtual_sensor import ObstacleView, Sector

VERSION = 1


def line(view: ObstacleView, sequence: int) -> bytes:
    """SI units and radians; null where there is no obstacle, no collision or nothing was heard."""
    told = {
        "echogrid": VERSION,
        "sequence": sequence,
        "stamp_ns": view.stamp_ns,
        "age_s": _seconds(view.age_ns),
        "stop": view.stop,
        "reason": view.reason.value if view.reason else None,
        "unknown": view.unknown.value,
        "silent": view.silent,
        "latency_s": _seconds(view.latency_ns),
        "speed_limit_mps": round(view.speed_limit, 4),
        "allowed": _twist(view.allowed),
        "path": _path(view.path),
        "sectors": [_sector(sector) for sector in view.sectors],
    }
    return json.dumps(told, allow_nan=False, separators=(",", ":")).encode() + b"\n"


def _path(path: FreePath) -> dict[str, object]:
    return {
        "twist": _twist(path.twist),
        "free_m": round(path.distance, 4),
        "collision_s": _finite(path.seconds),
        "end": path.end.value,
        "limit_mps": round(path.limit, 4),
    }


def _sector(sector: Sector) -> dict[str, object]:
    return {
        "bearing": round(sector.bearing, 4),
        "state": sector.state.value,
        "nearest_m": _finite(sector.nearest),
        "confidence": round(sector.confidence, 3),
        "age_s": _seconds(sector.age_ns),
        "seen": round(sector.seen, 3),
    }


def _twist(twist: Twist) -> tuple[float, float]:
    return round(twist.speed, 4), round(twist.turn_rate, 4)


def _finite(value: float) -> float | None:
    return None if isinf(value) else round(value, 4)


def _seconds(time_ns: int | None) -> float | None:
    return None if time_ns is None else round(time_ns * 1e-9, 6)
