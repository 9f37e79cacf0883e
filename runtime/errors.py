"""What a user did wrong, in words that name the place and the mend."""

from collections.abc import Sequence

from echogrid.drivers.errors import EchogridError
from echogrid.runtime.toml_lines import Place


class UsageError(EchogridError):
    """Bad configuration or input; all problems at once, one line each."""

    def __init__(self, problems: Sequence[str]) -> None:
        super().__init__("\n".join(problems))
        self.problems = tuple(problems)


class ConfigError(UsageError):
    """A configuration with which this can't be done; `robot_file.located` adds the file and the lines."""

    def __init__(self, found: Sequence[tuple[Place, str]]) -> None:
        super().__init__([f"robot.toml: {described(place, what)}" for place, what in found])
        self.found = tuple(found)


def described(place: Place, what: str) -> str:
    """The place, then what is wrong there; a key which that names itself is left out of the place."""
    if place and f"`{place[-1]}`" in what:
        place = place[:-1]
    table = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in place).lstrip(".")
    return f"{table}: {what}" if table else what
