"""What it means for avoidance that too little is known of a place."""

from enum import Enum


class Unknown(Enum):
    """Of a way or a direction, part of which was not seen, or not lately."""

    BLOCKED = "blocked"
    SLOW = "slow"
    """It may be driven into, slowly, and others are preferred."""
    CLEAR = "clear"
