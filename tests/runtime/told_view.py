"""An independent reader of the binary datagram, written from docs/obstacle-sensor.md alone."""

import struct
import zlib
from dataclasses import dataclass
from math import inf

REASONS = (None, "near", "silent", "unknown", "stale")
POLICIES = ("blocked", "slow", "clear")
STATES = ("clear", "blocked", "unknown", "stale")
ENDS = ("obstacle", "unknown", "stale", "horizon")


class RefusedError(ValueError):
    """It is no datagram of this version."""


@dataclass(frozen=True)
class ToldSector:
    bearing: float
    nearest: float
    age_s: float
    confidence: float
    state: str


@dataclass(frozen=True)
class Told:
    stop: bool
    silent: bool
    reason: str | None
    unknown: str
    sequence: int
    stamp_ns: int
    age_s: float
    latency_s: float
    speed_limit: float
    free: float
    collision_s: float
    twist: tuple[float, float]
    allowed: tuple[float, float]
    end: str
    sectors: tuple[ToldSector, ...]


def told(data: bytes) -> Told:
    """What a datagram says. Raises RefusedError."""
    if len(data) < 68:
        raise RefusedError("shorter than a header and its check")
    if data[0:4] != b"EGOV":
        raise RefusedError("no such datagram")
    if data[4] != 1:
        raise RefusedError(f"version {data[4]}")
    length, count = struct.unpack_from("<HH", data, 12)
    if length != len(data) or length != 64 + 8 * count + 4:
        raise RefusedError("of another length than it says")
    (check,) = struct.unpack_from("<I", data, length - 4)
    if check != zlib.crc32(data[: length - 4]):
        raise RefusedError("damaged")
    flags, reason, unknown = data[5], data[6], data[7]
    (sequence,) = struct.unpack_from("<I", data, 8)
    (stamp_ns,) = struct.unpack_from("<Q", data, 16)
    age_us, latency_us = struct.unpack_from("<II", data, 24)
    limit, free, collision, v, w, allowed_v, allowed_w = struct.unpack_from("<7f", data, 32)
    if flags > 3 or data[61:64] != bytes(3):
        raise RefusedError("bits that this version does not have")
    if reason >= len(REASONS) or unknown >= len(POLICIES) or data[60] >= len(ENDS):
        raise RefusedError("codes that this version does not have")
    return Told(
        bool(flags & 1),
        bool(flags & 2),
        REASONS[reason],
        POLICIES[unknown],
        sequence,
        stamp_ns,
        inf if age_us == 0xFFFFFFFF else age_us * 1e-6,
        latency_us * 1e-6,
        limit,
        free,
        collision,
        (v, w),
        (allowed_v, allowed_w),
        ENDS[data[60]],
        tuple(_sector(data, 64 + 8 * k) for k in range(count)),
    )


def _sector(data: bytes, offset: int) -> ToldSector:
    bearing, nearest, age, confidence, state = struct.unpack_from("<hHHBB", data, offset)
    return ToldSector(
        bearing * 1e-4,
        inf if nearest == 65535 else nearest * 1e-3,
        inf if age == 65535 else age * 1e-3,
        confidence / 255,
        STATES[state],
    )
