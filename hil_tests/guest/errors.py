"""Why there is no guest."""


class GuestError(Exception):
    """The guest cannot be made or started. Its text is one line, fit for a user."""
