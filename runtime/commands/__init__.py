"""The verbs of the command line, a module each: `add` says what it takes, `execute` does it."""
