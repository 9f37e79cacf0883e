"""How hypothesis looks for counter-examples: a machine that judges finds the same ones each time."""

import os

from hypothesis import settings

settings.register_profile("here", deadline=None, derandomize=bool(os.environ.get("CI")))
settings.load_profile("here")
