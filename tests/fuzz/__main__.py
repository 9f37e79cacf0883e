"""Feeds noise to the drivers of serial devices: `python -m tests.fuzz --bytes 10000000`."""

import sys
from argparse import ArgumentParser
from time import perf_counter

from .streams import fuzz, serial_drivers


def main() -> int:
    """0 if no driver did what it must not."""
    parser = ArgumentParser(prog="python -m tests.fuzz", description=__doc__)
    parser.add_argument("drivers", nargs="*", default=serial_drivers(), help="by name; default: all")
    parser.add_argument("--bytes", type=int, default=10_000_000, help="for each driver")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    failed = False
    for driver in arguments.drivers:
        began_s = perf_counter()
        tally = fuzz(driver, arguments.bytes, arguments.seed)
        lasted_s = perf_counter() - began_s
        rate = tally.bytes_fed / lasted_s / 1e6
        sys.stdout.write(
            f"{driver:14} {tally.bytes_fed:10} bytes {tally.readings:8} readings {tally.resyncs:5} resyncs "
            f"{lasted_s:6.1f} s {rate:6.2f} MB/s {len(tally.faults)} faults\n"
        )
        for fault in tally.faults[:10]:
            sys.stdout.write(f"    {driver} {fault}\n")
        failed |= bool(tally.faults)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
