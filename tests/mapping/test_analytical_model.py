from dataclasses import replace
from math import degrees, exp, log, pi, radians

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.analytical_model import Analytical, bessel_j1, piston
from echogrid.mapping.bayes import BayesGrid
from echogrid.mapping.cone import cast
from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.sonar_model import NoEcho
from echogrid.mapping.sounding import Sounding

from .strategies import poses, rangers

SPEED = 343.21461
POLAROID = Analytical(19.2e-3, SPEED / 49.4e3)
CAPSULE = Analytical(7.5e-3, SPEED / 40e3)
GEOMETRY = GridGeometry.covering(-2.0, -2.0, 6.0, 2.0, 0.1)
SONAR = Ranger("sonar", Pose(), radians(15.0), 0.3, 5.0)


@pytest.mark.parametrize(
    ("x", "due"),
    [(0.0, 0.0), (1.0, 0.4400505857), (2.0, 0.5767248078), (10.0, 0.0434727462), (20.0, 0.0668331242)],
)
def test_j1_at_the_tables_numbers(x: float, due: float) -> None:
    assert bessel_j1(np.array([x]))[0] == approx(due, abs=1e-9)


@given(st.floats(-40.0, 40.0))
def test_j1_satisfies_its_series_and_is_odd(x: float) -> None:
    assert bessel_j1(np.array([x]))[0] == approx(-bessel_j1(np.array([-x]))[0], abs=1e-12)
    if abs(x) < 3.0:
        terms = [1.0]
        for n in range(1, 25):
            terms.append(terms[-1] * -(x * x / 4.0) / (n * (n + 1)))
        assert bessel_j1(np.array([x]))[0] == approx(x / 2.0 * sum(terms), abs=1e-12)


@given(st.floats(-50.0, 50.0))
def test_no_beam_is_stronger_than_on_its_axis(x: float) -> None:
    assert abs(piston(np.array([x]))[0]) <= 1.0 + 1e-9
    assert piston(np.array([0.0]))[0] == 1.0


@pytest.mark.parametrize(
    ("model", "ka", "half_power", "null"),
    [(POLAROID, 17.3637, 5.332630, 12.748566), (CAPSULE, 5.492061, 17.087490, 44.241150)],
)
def test_the_beams_of_two_transducers(model: Analytical, ka: float, half_power: float, null: float) -> None:
    assert model.ka == approx(ka, abs=1e-4)
    assert degrees(model.angle_at(-3.0)) == approx(half_power, abs=1e-4)
    assert model.null is not None
    assert degrees(model.null) == approx(null, abs=1e-4)


@given(st.floats(1e-3, 0.1), st.floats(2e-3, 0.05))
def test_the_cone_ends_where_the_echo_is_30_db_down_or_nearly_at_the_side(
    radius: float, wavelength: float
) -> None:
    model = Analytical(radius, wavelength)
    assert 0.0 < model.half_angle < pi / 2.0
    down = -40.0 * np.log10(model.amplitude(np.array([model.half_angle]))[0])
    assert down == approx(30.0, abs=1e-3) or (model.half_angle == approx(radians(89.0)) and down < 30.0)


@settings(deadline=None)
@given(
    st.tuples(poses(3.0), rangers(0.05), st.none() | st.floats(0.0, 6.0)),
    st.sampled_from([POLAROID, CAPSULE]),
    st.sampled_from(NoEcho),
)
def test_an_echo_raises_its_band_and_all_else_lowers(ping, model: Analytical, no_echo: NoEcho) -> None:
    heard = model.believed(Sounding(*ping, 0.3))
    cone = cast(GEOMETRY, heard)
    found = model.echo(cone)
    assert np.all(np.isfinite(found))
    assert np.all(found[cone.occupied] >= 0.0)
    assert np.all(found[~cone.occupied] <= 0.0)
    assert np.all(model.silence(cone) <= 0.0)
    grid = BayesGrid(GEOMETRY, 4.6, model, no_echo)
    grid.update(Sounding(*ping, 0.3))
    assert np.all((grid.occupancy() > 0.0) & (grid.occupancy() < 1.0))


def test_the_evidence_of_one_echo_is_that_of_the_equations() -> None:
    cone = cast(GEOMETRY, CAPSULE.believed(Sounding(Pose(0.0, 0.05), SONAR, 1.0, 0.1)))
    beam = [float(CAPSULE.amplitude(np.array([alpha]))[0]) ** 2 * 0.45 for alpha in cone.bearing]
    on_arc = [answer for answer, occupied in zip(beam, cone.occupied, strict=True) if occupied]
    for index, answer in enumerate(beam):
        if cone.occupied[index]:
            q = 1.0 - 0.95 * exp(-0.05 * (sum(on_arc) - answer))
            due = log((answer + (1.0 - answer) * q) / q)
        else:
            quiet = answer * max(1.0 - (cone.distance[index] / 5.0) ** 2, 0.0)
            due = min(log((1.0 - quiet) / 0.95), 0.0)
        assert CAPSULE.echo(cone)[index] == approx(due, abs=1e-9)


def test_a_longer_arc_says_less_of_each_cell_on_it() -> None:
    strongest = [
        CAPSULE.echo(cast(GEOMETRY, CAPSULE.believed(Sounding(Pose(0.0, 0.05), SONAR, echo, 0.1)))).max()
        for echo in (0.5, 1.0, 2.0, 4.0)
    ]
    assert strongest == sorted(strongest, reverse=True)
    assert strongest[0] > 1.5 * strongest[-1]


def test_the_band_is_that_of_timing_alone() -> None:
    fine = GridGeometry.covering(0.0, -1.0, 5.0, 1.0, 0.01)
    needle = replace(SONAR, half_angle=0.1)
    for echo, due in ((0.5, 0.02), (4.0, 0.08)):
        cone = cast(fine, POLAROID.believed(Sounding(Pose(0.0, 0.005), needle, echo, 0.5)))
        assert np.ptp(cone.distance[cone.occupied]) / 2.0 == approx(due, abs=0.005)


@pytest.mark.parametrize(("radius", "wavelength"), [(0.0, 0.01), (0.01, 0.0), (float("nan"), 0.01)])
def test_an_impossible_transducer_is_refused(radius: float, wavelength: float) -> None:
    with pytest.raises(ValueError, match="above 0"):
        Analytical(radius, wavelength)
