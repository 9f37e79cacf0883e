"""A ranger's own tolerance, silence and detection go before those of the map."""

from dataclasses import replace
from math import radians

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from echogrid.mapping.analytical_model import Analytical
from echogrid.mapping.cone import cast
from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.long_term_map import LongTermMap
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import NoEcho, Ranger
from echogrid.mapping.sonar_model import HEARD, evidence
from echogrid.mapping.sounding import Sounding
from echogrid.mapping.subjective_model import Subjective
from echogrid.mapping.theories import THEORIES, Beliefs, maker

from .strategies import poses, rangers

GEOMETRY = GridGeometry.covering(-1.0, -2.0, 4.0, 2.0, 0.1)
SONAR = Ranger("sonar", Pose(), radians(15.0), 0.0, 4.0)
HEEDING = ("bayes", "dempster-shafer", "himm")


def map_of(theory: str, ranger: Ranger, policy: NoEcho, echo: float | None, tolerance: float = 0.1):
    long_term = LongTermMap(GEOMETRY, tolerance, maker(theory, Beliefs(no_echo=policy)))
    for _ in range(3):
        long_term.fuse(Pose(0.0, 0.05), ranger, echo)
    return long_term.render().occupancy


@pytest.mark.parametrize("theory", HEEDING)
@pytest.mark.parametrize("own", NoEcho)
@pytest.mark.parametrize("common", NoEcho)
def test_silence_means_what_the_ranger_says_whatever_the_map_says(
    theory: str, own: NoEcho, common: NoEcho
) -> None:
    found = map_of(theory, replace(SONAR, no_echo=own), common, None)
    assert np.array_equal(found, map_of(theory, SONAR, own, None))


@pytest.mark.parametrize("theory", THEORIES)
def test_the_band_of_an_echo_is_the_ranger_s_own(theory: str) -> None:
    own = map_of(theory, replace(SONAR, tolerance=0.3), NoEcho.WEAK, 2.0, 0.1)
    assert np.array_equal(own, map_of(theory, SONAR, NoEcho.WEAK, 2.0, 0.3))


@pytest.mark.parametrize("theory", THEORIES)
def test_other_rangers_of_the_same_map_are_as_before(theory: str) -> None:
    usual = map_of(theory, SONAR, NoEcho.WEAK, 2.0)
    long_term = LongTermMap(GEOMETRY, 0.1, maker(theory, Beliefs()))
    strange = replace(SONAR, name="strange", tolerance=0.4, no_echo=NoEcho.IGNORE, detection=0.9)
    long_term.fuse(Pose(0.0, 0.05), strange, None)
    for _ in range(3):
        long_term.fuse(Pose(0.0, 0.05), SONAR, 2.0)
    found = long_term.render().occupancy
    assert theory == "calibrated" or np.array_equal(found, usual)


@settings(deadline=None)
@given(poses(1.0), rangers(0.05), st.floats(0.0, 0.99), st.floats(0.0, 0.99))
def test_the_likelier_it_is_heard_the_more_its_silence_says(
    pose: Pose, ranger: Ranger, one: float, other: float
) -> None:
    less, more = sorted((one, other))
    for model in (Subjective(), Analytical(0.0075, 0.00858)):
        said = [
            evidence(
                cast(GEOMETRY, model.believed(Sounding(pose, replace(ranger, detection=each), None, 0.1))),
                model,
                NoEcho.WEAK,
            )
            for each in (less, more)
        ]
        assert np.all(said[1] <= said[0])
        assert np.all(said[0] <= 0.0)


@given(poses(1.0), rangers(0.05), st.none() | st.floats(0.0, 4.0))
def test_what_is_not_overridden_is_as_it_ever_was(pose: Pose, ranger: Ranger, echo: float | None) -> None:
    told = replace(ranger, detection=HEARD, no_echo=NoEcho.WEAK)
    for model in (Subjective(), Analytical(0.0075, 0.00858)):
        said = [
            evidence(cast(GEOMETRY, model.believed(Sounding(pose, each, echo, 0.1))), model, NoEcho.WEAK)
            for each in (ranger, told)
        ]
        assert said[0].tobytes() == said[1].tobytes()


def test_the_local_grid_heeds_it_too() -> None:
    def local(ranger: Ranger, echo: float | None, tolerance: float, policy: NoEcho) -> np.ndarray:
        grid = LocalGrid(0.1, 40, tolerance, 15.0, policy)
        grid.fuse(Pose(), ranger, echo, 1)
        return grid.grid.occupancy()

    clear = replace(SONAR, no_echo=NoEcho.CLEAR)
    assert np.array_equal(local(clear, None, 0.1, NoEcho.IGNORE), local(SONAR, None, 0.1, NoEcho.CLEAR))
    thick = replace(SONAR, tolerance=0.3)
    assert np.array_equal(local(thick, 1.5, 0.1, NoEcho.WEAK), local(SONAR, 1.5, 0.3, NoEcho.WEAK))


@pytest.mark.parametrize("detection", [-0.1, 1.0, 1.5])
def test_a_detection_that_is_no_probability_is_refused(detection: float) -> None:
    with pytest.raises(ValueError, match="probability of detection"):
        replace(SONAR, detection=detection)
