"""`python -m echogrid`: the command line."""

import sys

from echogrid.runtime.command_line import main

if __name__ == "__main__":
    sys.exit(main())
