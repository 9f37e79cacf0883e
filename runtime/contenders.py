"""The theories that are judged beside each other, and what each of them is made with."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

from echogrid.mapping.adaptive_beam import half_angle
from echogrid.mapping.forward_model import ForwardGrid
from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.himm import HimmGrid, Steps
from echogrid.mapping.range_layer import RangeLayerGrid, RangeLayerSettings
from echogrid.mapping.sonar_model import MAX_OCCUPIED, Form, NoEcho
from echogrid.mapping.sounding import Sounding
from echogrid.mapping.subjective_model import Subjective
from echogrid.mapping.theories import Beliefs, maker
from echogrid.mapping.theory import Theory
from echogrid.runtime.map_suite import Contender, Maker
from echogrid.runtime.ring_recording import RingPing

CALIBRATED = 0.35
"""What is likelier than that is called occupied; chosen in the worlds made to learn from."""
FASTEST = 0.4
"""m/s: what the tours' robot drives at most."""

_NARROWED = 1.0 / 3.0
"""beta_min over beta_max."""
_QUARTERS = 4
"""HIMM's counts are whole numbers; in quarters they can be turned up and down by a quarter."""


def contenders() -> tuple[Contender, ...]:
    """All that `echogrid evaluate` judges, the book's first."""
    baseline, ours = range_layer("nav2's range layer"), calibrated("calibrated", CALIBRATED)
    forward = Contender("forward model", partial(everywhere, ForwardGrid))
    return *_of_the_book(), _steady_by_speed(), counting("counting"), baseline, forward, ours


def _of_the_book() -> Iterator[Contender]:
    """How much depends on their numbers is looked at where silence is ignored."""
    for no_echo in NoEcho:
        for form in Form:
            yield _told(by_model(f"Bayes {form.value}", "bayes", form, no_echo), no_echo)
        yield _told(by_model("Dempster-Shafer", "dempster-shafer", Form.CONSISTENT, no_echo), no_echo)
    for growth, name in ((False, "HIMM"), (True, "HIMM, growth rate")):
        for no_echo in (NoEcho.IGNORE, NoEcho.CLEAR):
            yield _told(himm(name, no_echo, growth), no_echo)


def _told(contender: Contender, no_echo: NoEcho) -> Contender:
    numbers = contender.numbers if no_echo is NoEcho.IGNORE else None
    return replace(contender, name=f"{contender.name}, no echo: {no_echo.value}", numbers=numbers)


def _steady_by_speed() -> Contender:
    steady = by_model("Bayes murphy-consistent", "bayes", Form.CONSISTENT, NoEcho.IGNORE)
    return replace(by_speed(steady, FASTEST), name=f"{steady.name}, beta by speed")


def everywhere(make: Callable[[GridGeometry], Theory], _: str, geometry: GridGeometry) -> Theory:
    """A theory which is the same in every world, having learned in none."""
    return make(geometry)


def by_model(name: str, theory: str, form: Form, no_echo: NoEcho) -> Contender:
    """Bayes or Dempster-Shafer, as the long-term map has them."""
    surer = partial(_surer, theory, form, no_echo)
    return Contender(name, surer(1.0), of_the_book=True, numbers={"Max_occ": surer})


def by_speed(steady: Contender, fastest: float) -> Contender:
    """The same with a cone that is narrowest at that speed (m/s)."""
    return replace(steady, hear=partial(narrowed, fastest), numbers=None)


def himm(name: str, no_echo: NoEcho, growth: bool = False) -> Contender:
    """HIMM; its numbers are what an echo adds and takes."""
    rising, falling = (partial(_stepping, no_echo, growth, way) for way in ("up", "down"))
    make = partial(_himm_grid, no_echo, growth, Steps())
    return Contender(name, partial(everywhere, make), of_the_book=True, numbers={"I+": rising, "I-": falling})


def counting(name: str) -> Contender:
    """The reflection map."""
    return Contender(name, partial(everywhere, maker("counting", Beliefs())), numbers={})


def range_layer(name: str) -> Contender:
    """The baseline; its number is how far it believes."""
    return Contender(name, _deeper(1.0), numbers={"phi": _deeper})


def calibrated(name: str, threshold: float) -> Contender:
    """Calibrated evidence, which means what it says."""
    make = partial(everywhere, maker("calibrated", Beliefs()))
    return Contender(name, make, saturates=False, threshold=threshold, numbers={})


def narrowed(fastest: float, ping: RingPing) -> Sounding:
    """The ping with a cone as narrow as the robot is fast."""
    ranger = ping.sounding.ranger
    beta = half_angle(ping.speed, ranger.half_angle, _NARROWED * ranger.half_angle, fastest)
    return replace(ping.sounding, ranger=replace(ranger, half_angle=beta))


def _surer(theory: str, form: Form, no_echo: NoEcho, times: float) -> Maker:
    """Made with so many times Max_occ, which is 1 at most."""
    model = Subjective(form, max_occupied=min(times * MAX_OCCUPIED, 1.0))
    return partial(everywhere, maker(theory, Beliefs(model, no_echo)))


def _stepping(no_echo: NoEcho, growth: bool, way: str, times: float) -> Maker:
    """HIMM with so many times the step up or down, counting in quarters."""
    usual = Steps(*(_QUARTERS * step for step in (Steps().up, Steps().down, Steps().most)))
    steps = replace(usual, **{way: round(times * getattr(usual, way))})
    return partial(everywhere, partial(_himm_grid, no_echo, growth, steps))


def _himm_grid(no_echo: NoEcho, growth: bool, steps: Steps, geometry: GridGeometry) -> Theory:
    return HimmGrid(geometry, no_echo, growth, steps)


def _deeper(times: float) -> Maker:
    """The range layer which believes so many times as far."""
    settings = RangeLayerSettings(phi=times * RangeLayerSettings().phi)
    return partial(everywhere, partial(_range_layer_grid, settings))


def _range_layer_grid(settings: RangeLayerSettings, geometry: GridGeometry) -> Theory:
    return RangeLayerGrid(geometry, settings)
