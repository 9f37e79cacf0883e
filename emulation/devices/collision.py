"""Two devices that speak at once on one serial line."""

_DATA_BITS = 8


def collided(first: bytes, second: bytes, later_bits: int, bits_per_byte: int) -> bytes:
    """What a receiver makes of both, the second beginning so many bits later: who pulls the line low wins."""
    one = _levels(first, bits_per_byte)
    other = [1] * later_bits + _levels(second, bits_per_byte)
    length = max(len(one), len(other))
    one += [1] * (length - len(one))
    other += [1] * (length - len(other))
    return _received([a & b for a, b in zip(one, other, strict=True)])


def _levels(data: bytes, bits_per_byte: int) -> list[int]:
    """The line's level bit by bit: start bit, data with the lowest bit first, stop bits."""
    levels: list[int] = []
    for byte in data:
        levels += [0, *(byte >> bit & 1 for bit in range(_DATA_BITS))]
        levels += [1] * (bits_per_byte - 1 - _DATA_BITS)
    return levels


def _received(levels: list[int]) -> bytes:
    """The bytes read from it: one from each low level on which is no part of the byte before."""
    data = bytearray()
    at = 0
    while 0 in levels[at:]:
        start = levels.index(0, at) + 1
        bits = (levels[start : start + _DATA_BITS] + [1] * _DATA_BITS)[:_DATA_BITS]
        data.append(sum(bit << place for place, bit in enumerate(bits)))
        at = start + _DATA_BITS + 1
    return bytes(data)
