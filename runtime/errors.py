"""What a user did wrong, in words that name the place and the mend."""

from collections.abc import Sequence

from echogrid.drivers.errors import EchogridError


class UsageError(EchogridError):
    """Bad configuration or input; all problems at once, one line each."""

    def __init__(self, problems: Sequence[str]) -> None:
        super().__init__("\n".join(problems))
        self.problems = tuple(problems)
