"""`echogrid`, and `python -m echogrid`: the command line."""

import sys


def main() -> int:
    """Do what the arguments say; the exit code. Ctrl-C ends it quietly even while it is being loaded."""
    try:
        from echogrid.runtime import command_line

        return command_line.main()
    except KeyboardInterrupt:
        return 130


if __name__ == "__main__":
    sys.exit(main())
