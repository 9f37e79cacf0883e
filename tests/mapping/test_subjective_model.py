from math import radians

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.bayes import BayesGrid
from echogrid.mapping.cone import cast
from echogrid.mapping.dempster_shafer import simple_support
from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.sonar_model import Form, NoEcho, log_odds, printed
from echogrid.mapping.sounding import Sounding
from echogrid.mapping.subjective_model import Subjective

from .strategies import poses, rangers

GEOMETRY = GridGeometry.covering(-2.0, -2.0, 2.0, 2.0, 0.2)
SONAR = Ranger("sonar", Pose(), radians(15.0), 0.3, 4.0)


@settings(deadline=None)
@given(
    st.tuples(poses(2.0), rangers(0.05), st.none() | st.floats(0.0, 4.0)),
    st.sampled_from(Form),
    st.sampled_from(NoEcho),
)
def test_with_the_book_s_numbers_it_is_the_book_s_model_to_the_bit(ping, form: Form, no_echo: NoEcho) -> None:
    grids = [BayesGrid(GEOMETRY, 32.0, model, no_echo) for model in (form, Subjective(form))]
    touched = [grid.update(Sounding(*ping, 0.1)) for grid in grids]
    assert touched[0] == touched[1]
    assert np.array_equal(grids[0].log_odds, grids[1].log_odds)
    assert np.array_equal(grids[0].unknown(), grids[1].unknown())


@given(st.floats(0.5, 6.0), st.floats(0.01, 1.5), st.floats(0.0, 1.0), st.floats(0.0, 0.5))
def test_every_number_can_be_chosen(
    reach: float, half_angle: float, echo_part: float, tolerance: float
) -> None:
    model = Subjective(reach=reach, half_angle=half_angle, tolerance=tolerance)
    heard = model.believed(Sounding(Pose(), SONAR, echo_part * reach, 0.1))
    assert (heard.ranger.farthest, heard.ranger.half_angle) == (reach, half_angle)
    assert (heard.echo, heard.tolerance) == (echo_part * reach, tolerance)


def test_an_echo_from_beyond_the_chosen_reach_is_none() -> None:
    assert Subjective(reach=2.0).believed(Sounding(Pose(), SONAR, 2.1, 0.1)).echo is None


def test_what_is_not_chosen_is_the_ranger_s() -> None:
    ping = Sounding(Pose(), SONAR, 4.2, 0.1)
    assert Subjective().believed(ping) == ping


@pytest.mark.parametrize("max_occupied", [0.5, 0.98, 1.0])
def test_max_occ_bounds_an_echo_for_bayes_and_for_dempster_shafer(max_occupied: float) -> None:
    cone = cast(GEOMETRY, Sounding(Pose(-1.9, 0.1), SONAR, 2.0, 0.1))
    bayes = Subjective(Form.PRINTED, max_occupied).echo(cone)
    due = np.where(cone.occupied, cone.belief * max_occupied, printed(cone.belief, cone.occupied))
    assert bayes == approx(log_odds(due))
    masses = simple_support(Subjective(Form.CONSISTENT, max_occupied).echo(cone))
    assert masses.occupied == approx(np.where(cone.occupied, cone.belief * max_occupied, 0.0), abs=1e-9)
    assert masses.empty == approx(np.where(cone.occupied, 0.0, cone.belief), abs=1e-9)


@pytest.mark.parametrize("max_occupied", [0.0, 1.1, float("nan")])
def test_an_impossible_max_occ_is_refused(max_occupied: float) -> None:
    with pytest.raises(ValueError, match="Max_occ"):
        Subjective(max_occupied=max_occupied)
