"""Where somebody says how the robot shall move.

A wish is what is wanted, not what is done: the guard passes on the safe part of it.
"""

from collections import Counter
from typing import Protocol

from echogrid.mapping.twist import Twist

FRESH_NS = 300_000_000
"""A wish that is not repeated within this is none."""
STANDSTILL = Twist()


class Wishes(Protocol):
    """A source of twists. It never waits."""

    refused: Counter[str]
    """What came and was no wish, by reason."""

    def poll(self, now_ns: int) -> Twist:
        """What is wanted now; to stand, if nobody wants anything, or nobody can be heard."""
        ...

    def close(self) -> None:
        """Let the source go."""
        ...
