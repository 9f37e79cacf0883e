"""The theories by name, and what each is made with."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

from echogrid.mapping.bayes import BayesGrid
from echogrid.mapping.counting import CountingGrid
from echogrid.mapping.dempster_shafer import DempsterShaferGrid
from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.himm import HimmGrid
from echogrid.mapping.sonar_model import Form, NoEcho, SonarModel
from echogrid.mapping.theory import Theory

MAP_LIMIT = 4.6
"""nats: Bayes' long-term map stays within probabilities of 0.01 and 0.99."""


@dataclass(frozen=True, slots=True)
class Beliefs:
    """What theories are made with; each takes what it has a use for."""

    model: SonarModel = Form.CONSISTENT
    """Of Bayes and Dempster-Shafer."""
    no_echo: NoEcho = NoEcho.WEAK
    """Of these and HIMM."""


def _bayes(beliefs: Beliefs, geometry: GridGeometry) -> Theory:
    return BayesGrid(geometry, MAP_LIMIT, beliefs.model, beliefs.no_echo)


def _dempster_shafer(beliefs: Beliefs, geometry: GridGeometry) -> Theory:
    return DempsterShaferGrid(geometry, beliefs.model, beliefs.no_echo)


def _himm(beliefs: Beliefs, geometry: GridGeometry) -> Theory:
    return HimmGrid(geometry, beliefs.no_echo)


def _counting(_: Beliefs, geometry: GridGeometry) -> Theory:
    return CountingGrid(geometry)


def _calibrated(_: Beliefs, geometry: GridGeometry) -> Theory:
    # Its weights take a moment to load, and the other theories have no use for them.
    from echogrid.mapping.calibrated import CalibratedGrid

    return CalibratedGrid(geometry)


THEORIES: Mapping[str, Callable[[Beliefs, GridGeometry], Theory]] = {
    "bayes": _bayes,
    "dempster-shafer": _dempster_shafer,
    "himm": _himm,
    "counting": _counting,
    "calibrated": _calibrated,
}


def maker(name: str, beliefs: Beliefs) -> Callable[[GridGeometry], Theory]:
    """What makes a grid of that theory. Raises KeyError for a name that is not in the table."""
    return partial(THEORIES[name], beliefs)
