"""The names of the error codes in EMCY messages (CiA 301, table of emergency error codes; CiA 402)."""

NAMES = {
    0x1000: "generic error",
    0x2000: "current",
    0x2100: "current at the input",
    0x2200: "current inside the device",
    0x2300: "current at the output",
    0x2310: "continuous over-current",
    0x2320: "short circuit or earth leakage",
    0x3000: "voltage",
    0x3100: "mains voltage",
    0x3200: "voltage inside the device",
    0x3210: "over-voltage of the DC link",
    0x3220: "under-voltage of the DC link",
    0x3300: "output voltage",
    0x4000: "temperature",
    0x4100: "ambient temperature",
    0x4200: "temperature of the device",
    0x4300: "temperature of the drive",
    0x5000: "hardware of the device",
    0x6000: "software of the device",
    0x6100: "internal software",
    0x6200: "user's software",
    0x6300: "data set",
    0x7000: "additional modules",
    0x7120: "motor",
    0x7121: "motor blocked",
    0x7300: "sensor",
    0x7305: "incremental sensor 1",
    0x7310: "speed",
    0x7320: "position",
    0x8000: "monitoring",
    0x8100: "communication",
    0x8110: "CAN overrun",
    0x8120: "CAN error-passive",
    0x8130: "heartbeat of its master lost",
    0x8140: "back from bus-off",
    0x8150: "two nodes with one identifier",
    0x8200: "protocol",
    0x8210: "PDO too short",
    0x8220: "PDO too long",
    0x8400: "speed control",
    0x8500: "position control",
    0x8600: "positioning",
    0x8611: "following error",
    0x9000: "external error",
    0xF000: "additional functions",
    0xFF00: "its maker's own",
}
"""Those that users meet, and every class."""
_MASKS = (0xFFFF, 0xFFF0, 0xFF00, 0xF000)


def emergency_name(code: int) -> str:
    """The code, and the nearest name there is for it."""
    for mask in _MASKS:
        if name := NAMES.get(code & mask):
            return f"EMCY {code:#06x} ({name})"
    return f"EMCY {code:#06x}"


def is_reset(code: int) -> bool:
    """Whether it says that there is no error any more."""
    return code & 0xFF00 == 0


def blinds(code: int) -> bool:
    """Whether its position says nothing: the sensor has failed, unlike 0x7310 (speed) and 0x7320."""
    return code & 0xFFF0 == 0x7300


def is_communication(code: int) -> bool:
    """Whether it is about the bus, and not about the drive."""
    return code & 0xFF00 == 0x8100
