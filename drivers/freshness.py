"""Whether what a device said last still holds."""

PATIENCE_NS = 500_000_000
"""For so long a device that talks by itself, many times a second, may be silent."""


def is_old(stamp_ns: int | None, now_ns: int, patience_ns: int = PATIENCE_NS) -> bool:
    """Whether it was never said, or longer ago than that."""
    return stamp_ns is None or now_ns - stamp_ns > patience_ns
