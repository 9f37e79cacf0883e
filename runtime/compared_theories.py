"""The theories that `echogrid compare` sets beside each other, each as one that is judged."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial

from echogrid.mapping.adaptive_beam import half_angle
from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.himm import HimmGrid
from echogrid.mapping.range_layer import RangeLayerGrid, RangeLayerSettings
from echogrid.mapping.sonar_model import MAX_OCCUPIED, Form, NoEcho
from echogrid.mapping.sounding import Sounding
from echogrid.mapping.subjective_model import Subjective
from echogrid.mapping.theories import Beliefs, maker
from echogrid.mapping.theory import Theory
from echogrid.runtime.contenders import everywhere
from echogrid.runtime.map_suite import Contender, Maker
from echogrid.runtime.ring_recording import RingPing

WHAT_IT_IS: Mapping[str, str] = {
    "bayes-printed": "Bayes with the sonar model as the book prints it (11.1, 11.2)",
    "bayes": "Bayes with the consistent model: the pignistic probability of Dempster-Shafer's masses",
    "bayes-by-speed": "bayes, with a cone that narrows to a third as the robot gets faster",
    "dempster-shafer": "Dempster's rule (11.9); the picture is BetP",
    "himm": "HIMM: counts on the axis (11.11); the picture is C/15",
    "himm-growth": "himm with the growth rate operator",
    "counting": "the reflection map: hits over hits and misses",
    "range-layer": "the model of nav2's range layer, with its defaults",
    "calibrated": "calibrated evidence, the long-term map's default",
}
"""By name, in the order of the report."""
MATCHED = "bayes", "dempster-shafer"
"""The pair that believes the same of each single ping: what differs is the way of combining alone."""

_NARROWED = 1.0 / 3.0
"""beta_min over beta_max."""


def contenders(names: tuple[str, ...], no_echo: NoEcho, fastest: float) -> tuple[Contender, ...]:
    """Those of the names, in the order of the report. `fastest` (m/s) is at what the cone is narrowest."""
    makers: Mapping[str, Callable[[], Contender]] = {
        "bayes-printed": partial(_by_model, "bayes-printed", "bayes", Form.PRINTED, no_echo),
        "bayes": partial(_by_model, "bayes", "bayes", Form.CONSISTENT, no_echo),
        "bayes-by-speed": partial(_by_speed, no_echo, fastest),
        "dempster-shafer": partial(_by_model, "dempster-shafer", "dempster-shafer", Form.CONSISTENT, no_echo),
        "himm": partial(_himm, "himm", no_echo, growth=False),
        "himm-growth": partial(_himm, "himm-growth", no_echo, growth=True),
        "counting": partial(_named, "counting", no_echo),
        "range-layer": _range_layer,
        "calibrated": partial(_named, "calibrated", no_echo),
    }
    return tuple(makers[name]() for name in WHAT_IT_IS if name in names)


def narrowed(fastest: float, ping: RingPing) -> Sounding:
    """The ping with a cone as narrow as the robot is fast."""
    ranger = ping.sounding.ranger
    beta = half_angle(ping.speed, ranger.half_angle, _NARROWED * ranger.half_angle, fastest)
    return replace(ping.sounding, ranger=replace(ranger, half_angle=beta))


def _named(name: str, no_echo: NoEcho) -> Contender:
    make = maker(name, Beliefs(no_echo=no_echo))
    return Contender(name, partial(everywhere, make), saturates=name != "calibrated", numbers={})


def _by_model(name: str, theory: str, form: Form, no_echo: NoEcho) -> Contender:
    make = maker(theory, Beliefs(form, no_echo))
    surer = partial(_surer, theory, form, no_echo)
    return Contender(name, partial(everywhere, make), of_the_book=True, numbers={"Max_occ": surer})


def _surer(theory: str, form: Form, no_echo: NoEcho, times: float) -> Maker:
    """Made with so many times Max_occ, which is 1 at most."""
    model = Subjective(form, max_occupied=min(times * MAX_OCCUPIED, 1.0))
    return partial(everywhere, maker(theory, Beliefs(model, no_echo)))


def _by_speed(no_echo: NoEcho, fastest: float) -> Contender:
    steady = _by_model("bayes-by-speed", "bayes", Form.CONSISTENT, no_echo)
    return replace(steady, hear=partial(narrowed, fastest), numbers=None)


def _himm(name: str, no_echo: NoEcho, growth: bool) -> Contender:
    make = partial(_himm_grid, no_echo, growth)
    return Contender(name, partial(everywhere, make), of_the_book=True, numbers={})


def _himm_grid(no_echo: NoEcho, growth: bool, geometry: GridGeometry) -> Theory:
    return HimmGrid(geometry, no_echo, growth)


def _range_layer() -> Contender:
    return Contender("range-layer", _deeper(1.0), numbers={"phi": _deeper})


def _deeper(times: float) -> Maker:
    """The range layer which believes so many times as far."""
    settings = RangeLayerSettings(phi=times * RangeLayerSettings().phi)
    return partial(everywhere, partial(_range_layer_grid, settings))


def _range_layer_grid(settings: RangeLayerSettings, geometry: GridGeometry) -> Theory:
    return RangeLayerGrid(geometry, settings)
