"""The plain kernel within a compressed one: QEMU starts it at once, without a boot loader's detour."""

import lzma
import struct
import zlib

SECTOR = 512
SETUP_SECTORS = 0x1F1
PAYLOAD = 0x248
XZ, GZIP, ELF = b"\xfd7zXZ\0", b"\x1f\x8b", b"\x7fELF"


def extract(image: bytes) -> bytes | None:
    """The ELF file in a bzImage; None if it is compressed in another way than xz or gzip.

    Offsets are those of the x86 boot protocol, 2.08 and later.
    """
    setup_sectors = image[SETUP_SECTORS] or 4
    offset, length = struct.unpack_from("<II", image, PAYLOAD)
    start = (setup_sectors + 1) * SECTOR + offset
    payload = image[start : start + length]
    if payload.startswith(XZ):
        plain = lzma.LZMADecompressor().decompress(payload)
    elif payload.startswith(GZIP):
        plain = zlib.decompressobj(31).decompress(payload)
    else:
        return None
    return plain if plain.startswith(ELF) else None
