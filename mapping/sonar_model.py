"""What a ping says about a cell: what sonar models have in common, and the book's, printed and repaired.

The printed model (11.1, 11.2) has a defect of sign: where b falls below 1/2 (0.51 in region I), an echo
lowers the probability of its own obstacle, and empty space raises it; at s = 0.95 R that is 97 % of region I
and 60 % of region II. The consistent form keeps the book's b and moves it to the right side of 1/2. It is
also the pignistic probability of the book's own Dempster-Shafer masses (11.7, 11.8).

Other models: subjective_model.py, analytical_model.py and empirical_model.py.
"""

from enum import Enum
from math import log, radians
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from echogrid.mapping.cone import Cone, Reach
from echogrid.mapping.ranger import NoEcho as NoEcho
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.sounding import Sounding

Floats = NDArray[np.float64]

MAX_OCCUPIED = 0.98
"""Max_occ of the book: an echo is never more certain than this."""

_SUREST = 1e-3
"""No single ping may claim more: a probability of 0 or 1 could never be taken back."""

FALSE = 0.05
"""p_fa: how often a cone answers though the cell is empty."""
HEARD = 0.45
"""p_d of an obstacle on the axis and near: smooth walls met at a slant are often silent."""
_NO_ECHO_ANGLE = radians(8.0)
_NO_ECHO_REACH = 0.6


class SonarModel(Protocol):
    """What a ping says of the cells of its cone."""

    def believed(self, sounding: Sounding) -> Sounding:
        """The ping with the cone, the reach and the band that the model gives it."""
        ...

    def echo(self, cone: Cone) -> Floats:
        """(n,) ln(P(s|Occupied)/P(s|Empty)) of an echo, or of a cone that is believed to be clear."""
        ...

    def silence(self, cone: Cone) -> Floats:
        """(n,) The same of nothing that came back, weighed by how often an obstacle is not heard."""
        ...


class Form(Enum):
    """The book's model: as printed, or repaired. All that it needs of a ranger is the ranger's own."""

    PRINTED = "murphy"
    CONSISTENT = "murphy-consistent"

    def believed(self, sounding: Sounding) -> Sounding:
        """The ping as it is."""
        return sounding

    def echo(self, cone: Cone) -> Floats:
        """(n,) ln(P(s|Occupied)/P(s|Empty))."""
        return log_odds(self.probability(cone, MAX_OCCUPIED))

    def silence(self, cone: Cone) -> Floats:
        """(n,) Of silence, which the book is silent about."""
        return weak_silence(cone)

    def probability(self, cone: Cone, max_occupied: float) -> Floats:
        """(n,) P(s|Occupied)."""
        model = printed if self is Form.PRINTED else consistent
        return model(cone.belief, cone.occupied, max_occupied)


def printed(belief: Floats, occupied: NDArray[np.bool_], max_occupied: float = MAX_OCCUPIED) -> Floats:
    """P(s|Occupied) as printed: b Max_occ in region I (11.1), 1 - b in region II (11.2). P(s|Empty) is the
    rest to 1."""
    return np.where(occupied, belief * max_occupied, 1.0 - belief)


def consistent(belief: Floats, occupied: NDArray[np.bool_], max_occupied: float = MAX_OCCUPIED) -> Floats:
    """P(s|Occupied) on the right side of 1/2: (1 + b Max_occ)/2 in region I, (1 - b)/2 in region II."""
    result: Floats = 0.5 + 0.5 * belief * np.where(occupied, max_occupied, -1.0)
    return result


def posterior(given_occupied: float, given_empty: float, prior: float) -> float:
    """P(Occupied|s) by Bayes' rule from the two likelihoods and the prior (11.3, 11.4; recursive: 11.6)."""
    occupied = given_occupied * prior
    return occupied / (occupied + given_empty * (1.0 - prior))


def log_odds(probability: Floats) -> Floats:
    """ln(p/(1-p)), with p kept from 0 and 1."""
    p = np.minimum(np.maximum(probability, _SUREST), 1.0 - _SUREST)
    result: Floats = np.log(p)
    result -= np.log1p(-p)
    return result


def no_echo_log_odds(detection: Floats) -> Floats:
    """ln((1 - p_d)/(1 - p_fa)): what silence says of a cell whose obstacle would have answered with
    probability p_d; nothing where p_d is below p_fa."""
    result: Floats = np.minimum(np.log1p(-detection) - log(1.0 - FALSE), 0.0)
    return result


def evidence(cone: Cone, model: SonarModel, no_echo: NoEcho) -> Floats:
    """(n,) The log-likelihood ratio of occupied against empty for each of the cone's cells; silence is worth
    `no_echo`, or what the ranger has for its own."""
    policy = cone.ranger.no_echo or no_echo
    if cone.echo or policy is NoEcho.CLEAR:
        return model.echo(cone)
    return model.silence(cone) if policy is NoEcho.WEAK else np.zeros(len(cone.rows))


def heard(ranger: Ranger) -> float:
    """p_d of an obstacle on the ranger's axis, and near."""
    return HEARD if ranger.detection is None else ranger.detection


def silent_reach(ranger: Ranger) -> Reach:
    """How far weak silence speaks at all: what lies beyond need not be looked at."""
    return Reach(min(ranger.half_angle, _NO_ECHO_ANGLE), _NO_ECHO_REACH * ranger.farthest)


def weak_silence(cone: Cone) -> Floats:
    """(n,) Log-likelihood ratios of silence; p_d falls to nothing 8 deg off the axis, and at 0.6 of the
    reach."""
    central = np.maximum(1.0 - (cone.bearing / _NO_ECHO_ANGLE) ** 2, 0.0)
    near = np.maximum(1.0 - (cone.distance / (_NO_ECHO_REACH * cone.ranger.farthest)) ** 2, 0.0)
    return no_echo_log_odds(heard(cone.ranger) * central * near)
