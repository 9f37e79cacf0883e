"""Feeds noise to the drivers of serial devices and of wheels on CAN: `python -m tests.fuzz`."""

import sys
from argparse import ArgumentParser
from time import perf_counter

from . import frames, streams


def main() -> int:
    """0 if no driver did what it must not."""
    serial, can = streams.serial_drivers(), frames.can_drivers()
    parser = ArgumentParser(prog="python -m tests.fuzz", description=__doc__)
    parser.add_argument("drivers", nargs="*", default=[*serial, *can], help="by name; default: all")
    parser.add_argument("--bytes", type=int, default=10_000_000, help="for each of a serial device")
    parser.add_argument("--frames", type=int, default=1_000_000, help="for each on CAN")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    failed = False
    for driver in arguments.drivers:
        began_s = perf_counter()
        if driver in can:
            tally = frames.fuzz(driver, arguments.frames, arguments.seed)
        else:
            tally = streams.fuzz(driver, arguments.bytes, arguments.seed)
        lasted_s = perf_counter() - began_s
        sys.stdout.write(
            f"{driver:17} {tally.fed:10} {tally.unit:6} {tally.readings:8} readings {tally.resyncs:5} resyncs"
            f" {lasted_s:6.1f} s {tally.fed / lasted_s / 1e6:6.2f} M/s {len(tally.faults)} faults\n"
        )
        for fault in tally.faults[:3]:
            sys.stdout.write(f"    {driver} {fault}\n")
        failed |= bool(tally.faults)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
