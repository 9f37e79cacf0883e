"""What goes wrong with ports and devices: one root, few leaves.

Each leaf is also the builtin that a stranger would catch.
"""


class EchogridError(Exception):
    """The root of every error that echogrid raises on purpose. Its text is fit for a user."""


class PortError(EchogridError, OSError):
    """A port is missing, forbidden or lost. The text names the port and the mend."""


class UnknownDriverError(EchogridError, LookupError):
    """No driver of that name."""
