from math import degrees, radians

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from echogrid.mapping import beam_profile
from echogrid.mapping.beam_profile import BeamProfile
from echogrid.mapping.wall_trials import Trials

profiles = st.builds(
    BeamProfile,
    half_angle=st.floats(radians(10.0), radians(35.0)),
    fading=st.floats(0.0, 0.15),
    blur=st.floats(radians(4.0) ** 2, radians(10.0) ** 2),
    top=st.floats(0.7, 1.0),
    floor=st.floats(0.0, 0.1),
    middle=st.just(1.0),
)


def drawn(profile: BeamProfile, yaw: float, seed: int, count: int = 3000) -> Trials:
    """Trials of walls all around, heard as the profile says by a ranger whose axis is `yaw` to the left."""
    random = np.random.default_rng(seed)
    bearing = random.uniform(radians(-60.0), radians(60.0), count)
    distance = random.uniform(0.4, 2.0, count)
    heard = random.random(count) < profile.detection(bearing - yaw, distance)
    reading = np.where(heard, distance, np.nan)
    number = np.arange(count)
    tolerance, ones = np.full(count, 0.1), np.ones(count)
    return Trials(
        np.zeros(count, np.intp),
        number,
        number // 50,
        reading,
        ones,
        bearing,
        distance,
        tolerance,
        ones,
        np.ones(count, np.bool_),
    )


@settings(deadline=None, max_examples=15)
@given(profiles, st.integers(0, 99))
def test_the_profile_by_which_walls_were_heard_is_found_again(true: BeamProfile, seed: int) -> None:
    trials = drawn(true, 0.0, seed)
    found = beam_profile.fitted(trials)
    assert found.likelihood(trials) >= true.likelihood(trials) - 4.0
    for distance in (0.7, 1.0, 1.5):
        assert found.half_angle_at(distance) == pytest.approx(true.half_angle_at(distance), abs=radians(3.0))


@settings(deadline=None, max_examples=15)
@given(profiles, st.floats(-8.0, 8.0), st.integers(0, 99))
def test_an_axis_that_is_turned_is_found(true: BeamProfile, yaw_deg: float, seed: int) -> None:
    trials = drawn(true, radians(yaw_deg), seed)
    assert degrees(beam_profile.yaw_of(trials, true)) == pytest.approx(yaw_deg, abs=1.5)


@settings(deadline=None, max_examples=10)
@given(profiles, st.integers(0, 99))
def test_a_ranger_s_own_half_angle_is_found(true: BeamProfile, seed: int) -> None:
    found = beam_profile.half_angle_of(drawn(true, 0.0, seed), true)
    assert found == pytest.approx(true.half_angle, abs=radians(1.5))


@given(profiles, st.floats(0.0, 1.0), st.floats(0.0, 1.0), st.floats(0.2, 4.0))
def test_what_is_further_off_the_axis_is_heard_less(
    profile: BeamProfile, one: float, other: float, distance: float
) -> None:
    near, far = sorted((one, other))
    heard = profile.detection(np.array((near, far)), np.array((distance, distance)))
    assert heard[1] <= heard[0]
    assert 0.0 < heard.min() <= heard.max() < 1.0


def test_a_wall_too_far_for_the_axis_itself_has_a_half_angle_of_nothing() -> None:
    fading = BeamProfile(radians(10.0), 0.1, radians(5.0) ** 2, 1.0, 0.0, 1.0)
    assert fading.half_angle_at(10.0) == 0.0
    assert fading.half_angle_at(1.0) == radians(10.0)
