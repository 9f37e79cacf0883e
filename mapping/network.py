"""A small network that turns what is known of a cell into a probability."""

from collections.abc import Mapping
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_FARTHEST = 4.0
"""Standard deviations: what is stranger than that counts as so strange."""


@dataclass(frozen=True)
class Network:
    """A logistic model of the features themselves, and of a few hidden sums of them.

    logit = x . direct + tanh(x . hidden + hidden_bias) . output + bias, where x are the features less their
    mean in units of their scale.
    """

    mean: Floats
    """(n,)."""
    scale: Floats
    """(n,)."""
    direct: Floats
    """(n,)."""
    hidden: Floats
    """(n, h)."""
    hidden_bias: Floats
    """(h,)."""
    output: Floats
    """(h,)."""
    bias: Floats
    """(1,)."""

    @classmethod
    def of(cls, numbers: Mapping[str, str]) -> "Network":
        """The network of such numbers, as they are shipped: in the order of their rows, apart by blanks."""
        arrays = {name: np.array(text.split(), np.float64) for name, text in numbers.items()}
        arrays["hidden"] = arrays["hidden"].reshape(len(arrays["mean"]), -1)
        return cls(**arrays)

    def numbers(self) -> dict[str, NDArray[np.float64]]:
        """All its numbers by name."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    def standardised(self, features: Floats) -> Floats:
        """(..., n) x of features of that shape."""
        result: Floats = np.clip((features - self.mean) / self.scale, -_FARTHEST, _FARTHEST)
        return result

    def log_odds(self, features: Floats) -> Floats:
        """(...) of features (..., n)."""
        x = self.standardised(features)
        result: Floats = (
            x @ self.direct + np.tanh(x @ self.hidden + self.hidden_bias) @ self.output + self.bias
        )
        return result
