"""Frames as `candump -L` logs them."""

import re
from collections import defaultdict
from collections.abc import Iterable, Sequence
from itertools import pairwise
from math import inf
from statistics import median

from echogrid.drivers.bus import CanFrame

LINE = re.compile(
    r"^\((\d+)\.(\d{6})\) \S+ ([0-9A-F]{8}|[0-9A-F]{3})#(#[0-9A-F]|R?)([0-9A-F]*)(?: [RT])?$", re.MULTILINE
)

FEW = 10
Kind = tuple[int, bool, bool, int]
"""Identifier, extended, remote, length."""


def logged(text: str) -> list[CanFrame]:
    """The frames, stamped by the wall clock."""
    return [_frame(*line) for line in LINE.findall(text)]


def _frame(seconds: str, micros: str, identifier: str, mark: str, data: str) -> CanFrame:
    remote = mark == "R"  # a digit behind it is the length that is asked for
    return CanFrame(
        int(identifier, 16),
        b"" if remote else bytes.fromhex(data),
        len(identifier) == 8,
        remote,
        int(seconds) * 1_000_000_000 + int(micros) * 1000,
        mark.startswith("#"),
    )


def periods(frames: Iterable[CanFrame]) -> dict[Kind, float]:
    """From one to the next of each kind, s, in the middle; infinite if there are few."""
    stamps_ns: dict[Kind, list[int]] = defaultdict(list)
    for frame in frames:
        kind = frame.identifier, frame.extended, frame.remote, len(frame.data)
        stamps_ns[kind].append(frame.stamp_ns)
    return {kind: _period(stamps) for kind, stamps in stamps_ns.items()}


def _period(stamps_ns: Sequence[int]) -> float:
    return median(b - a for a, b in pairwise(stamps_ns)) * 1e-9 if len(stamps_ns) >= FEW else inf
