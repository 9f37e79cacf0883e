"""What goes wrong when an emulated robot is built, served or asked to fail."""

from echogrid.drivers.errors import EchogridError


class EmulationError(EchogridError):
    """The root of the emulator's errors. Its text is fit for a user."""


class RobotSpecError(EmulationError, ValueError):
    """A robot that cannot be built. The text names the part and the mend."""


class UnknownNameError(EmulationError, LookupError):
    """The robot has no device or bus of that name."""


class UnknownVerbError(EmulationError, LookupError):
    """The device or bus has no fault of that name."""


class DirectoryError(EmulationError, OSError):
    """The robot cannot be served from that directory."""


class ControlError(EmulationError, OSError):
    """The control socket does not answer, or refuses."""
