"""The theories that are judged beside each other."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from math import radians
from typing import Self

import numpy as np

from echogrid.mapping.adaptive_beam import half_angle
from echogrid.mapping.bayes import BayesGrid, Cells
from echogrid.mapping.calibrated import CalibratedGrid
from echogrid.mapping.cone import Cone
from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.sonar_model import Form, NoEcho
from echogrid.mapping.sounding import Sounding
from echogrid.mapping.theories import MAP_LIMIT
from echogrid.mapping.theory import Theory
from echogrid.runtime.map_suite import Contender, Maker
from echogrid.runtime.ring_recording import HALF_ANGLE, RingPing

NARROWEST = radians(5.0)
"""Of the cone at full speed."""
CALIBRATED = 0.35
"""What is likelier than that is called occupied; chosen in the worlds made to learn from."""
FASTEST = 0.4
"""m/s: what the tours' robot drives at most."""


def everywhere(make: Callable[[GridGeometry], Theory], _: str, geometry: GridGeometry) -> Theory:
    """A theory which is the same in every world, having learned in none."""
    return make(geometry)


def bayes(form: Form, no_echo: NoEcho, geometry: GridGeometry) -> Theory:
    """As the long-term map has it."""
    return BayesGrid(geometry, MAP_LIMIT, form, no_echo)


def by_speed(ping: RingPing) -> Sounding:
    """The ping with a cone as narrow as the robot is fast."""
    beta = half_angle(ping.speed, HALF_ANGLE, NARROWEST, FASTEST)
    return replace(ping.sounding, ranger=replace(ping.sounding.ranger, half_angle=beta))


class SurerBayes(BayesGrid):
    """Bayes' grid with so many times Max_occ, which only stands beside b, and only in region I (11.1)."""

    times = 1.0

    def fuse(self, cone: Cone) -> Cells:
        """Fuse one ping; the cells of which it spoke."""
        belief = np.where(cone.occupied, cone.belief * self.times, cone.belief)
        return super().fuse(replace(cone, belief=belief))

    def copy(self) -> Self:
        """An independent twin."""
        twin = super().copy()
        twin.times = self.times
        return twin


def surer_bayes(form: Form, no_echo: NoEcho, times: float) -> Maker:
    """The maker of Bayes' grids with so many times Max_occ."""
    return partial(everywhere, partial(_surer_bayes, form, no_echo, times))


def _surer_bayes(form: Form, no_echo: NoEcho, times: float, geometry: GridGeometry) -> Theory:
    grid = SurerBayes(geometry, MAP_LIMIT, form, no_echo)
    grid.times = times
    return grid


def contenders() -> tuple[Contender, ...]:
    """All of them, the book's first."""
    steady = _bayes(Form.CONSISTENT, NoEcho.IGNORE)
    by_the_book = [_bayes(form, no_echo) for form in Form for no_echo in NoEcho]
    adaptive = replace(steady, name=f"{steady.name}, beta by speed", hear=by_speed, numbers=None)
    calibrated = Contender(
        "calibrated", partial(everywhere, CalibratedGrid), saturates=False, threshold=CALIBRATED, numbers={}
    )
    return (*by_the_book, adaptive, calibrated)


def _bayes(form: Form, no_echo: NoEcho) -> Contender:
    return Contender(
        f"Bayes {form.value}, no echo: {no_echo.value}",
        partial(everywhere, partial(bayes, form, no_echo)),
        of_the_book=True,
        numbers={"Max_occ": partial(surer_bayes, form, no_echo)} if no_echo is NoEcho.IGNORE else None,
    )
