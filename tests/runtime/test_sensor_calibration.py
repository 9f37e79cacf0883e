"""What a log tells of its rangers, where the emulated acoustics say what is true."""

from dataclasses import replace
from functools import cache
from math import degrees, log10, radians, sqrt

import pytest

from echogrid.emulation.piston import TWO_WAY_LOSS_AT_NULL
from echogrid.mapping.sensor_calibration import Beam, Calibration, Estimate, Noise, TooFew
from echogrid.runtime import reference_map, sensor_calibration
from echogrid.runtime.errors import UsageError
from echogrid.runtime.sensor_calibration import Result

from . import sensor_logs
from .sensor_logs import MODEL, NAMES, RIGHT, Trick

WRONG = Trick({"left": 4.0, "right": -4.0}, {"rear": 0.05})
"""robot.toml has two mounting angles wrong; one ranger tells 5 cm too much."""


@cache
def by_the_room(seconds: float, wrong: bool = False) -> Result:
    """Of all four, judged by the room as it is."""
    recording = sensor_logs.log(seconds, WRONG if wrong else RIGHT)
    pings = reference_map.placed(recording)
    (result,) = sensor_calibration.results(recording, pings, sensor_logs.room(), 1)
    return result


@cache
def by_its_own_map(seconds: float) -> Result:
    """The same, judged by what the log itself tells of the room."""
    recording = sensor_logs.log(seconds, WRONG)
    pings = reference_map.placed(recording)
    reference = reference_map.of_itself(recording, pings)
    (result,) = sensor_calibration.results(recording, pings, reference, 1)
    return result


def wrong_by_the_room() -> Result:
    return by_the_room(150.0, wrong=True)


def yaws_deg(found: Calibration) -> dict[str, float]:
    return {NAMES[own.sensor]: degrees(own.yaw.value) for own in found.own if isinstance(own.yaw, Estimate)}


def biases_m(found: Calibration) -> dict[str, float]:
    return {NAMES[own.sensor]: own.bias.value for own in found.own if isinstance(own.bias, Estimate)}


def acoustic_half_angle(distance: float) -> float:
    """rad: where a smooth wall's echo has sunk to the threshold, by the data of the emulated transducer."""
    way = max(distance, MODEL.ramp_end)
    loss = 20.0 * log10(way / MODEL.level_range) + 2.0 * MODEL.absorption * (way - MODEL.level_range)
    return MODEL.null_angle * sqrt((MODEL.sensitivity - loss) / TWO_WAY_LOSS_AT_NULL)


@pytest.mark.parametrize("found", [wrong_by_the_room, lambda: by_its_own_map(240.0)])
def test_a_mounting_angle_that_is_wrong_by_4_degrees_is_found_within_1(found) -> None:
    yaws = yaws_deg(found().found)
    assert yaws["left"] == pytest.approx(-4.0, abs=1.0)
    assert yaws["right"] == pytest.approx(4.0, abs=1.0)
    assert yaws["front"] == pytest.approx(0.0, abs=1.0)
    assert yaws["rear"] == pytest.approx(0.0, abs=1.0)


@pytest.mark.parametrize("found", [wrong_by_the_room, lambda: by_its_own_map(240.0)])
def test_a_bias_of_5_cm_is_found_within_1(found) -> None:
    biases = biases_m(found().found)
    assert biases.pop("rear") == pytest.approx(0.05, abs=0.01)
    assert list(biases.values()) == pytest.approx([0.0, 0.0, 0.0], abs=0.01)


@pytest.mark.parametrize("found", [wrong_by_the_room, lambda: by_its_own_map(240.0)])
def test_the_half_angle_is_that_of_the_acoustics_within_2_degrees(found) -> None:
    beam = found().found.beam
    assert isinstance(beam, Beam)
    true = acoustic_half_angle(beam.profile.middle)
    assert beam.half_angle.value == pytest.approx(true, abs=radians(2.0))
    assert beam.half_angle.error < radians(1.0)
    assert beam.profile.half_angle_at(2.0) == pytest.approx(acoustic_half_angle(2.0), abs=radians(3.0))


def test_the_noise_is_that_of_the_emulated_detector() -> None:
    noise = wrong_by_the_room().found.noise
    assert isinstance(noise, Noise)
    for distance in (0.5, 1.0, 1.5):
        assert noise.model.sigma(distance) == pytest.approx(0.005 + 0.01 * distance, abs=0.006)


def test_walls_on_the_axis_are_nearly_always_heard_and_those_far_off_it_not() -> None:
    beam = wrong_by_the_room().found.beam
    assert isinstance(beam, Beam)
    assert beam.profile.top > 0.9
    assert beam.profile.floor < 0.1


@pytest.mark.parametrize("found", [wrong_by_the_room, lambda: by_its_own_map(240.0)])
def test_the_counted_model_foretells_the_other_half_better_than_the_configured_one(found) -> None:
    trial = found().trial
    assert trial is not None
    assert trial.skills.empirical > trial.skills.configured + 0.05
    assert 0.0 < trial.factor < 0.3


def test_of_a_short_log_nothing_is_claimed_but_what_is_missing_is_told() -> None:
    result = by_the_room(6.0)
    assert isinstance(result.found.beam, TooFew)
    assert isinstance(result.found.noise, TooFew)
    assert result.found.beam.found < result.found.beam.needed
    assert not yaws_deg(result.found)


def test_a_log_without_poses_or_pings_is_refused() -> None:
    recording = replace(sensor_logs.log(6.0), ranges=[])
    with pytest.raises(UsageError, match="no ping at any pose"):
        sensor_calibration.results(recording, [], sensor_logs.room(), 1)
    lost = replace(sensor_logs.log(6.0), poses=[])
    with pytest.raises(UsageError, match="no usable pose"):
        reference_map.of_itself(lost, reference_map.placed(lost))


def test_rangers_that_are_not_alike_are_of_different_kinds() -> None:
    one, *others = sensor_logs.sensors()
    wide = replace(one, name="wide", half_angle_deg=20.0)
    sonar = replace(one, name="sonar", driver="srf08", bus="i2c")
    kinds = sensor_calibration.kinds([one, wide, *others, sonar])
    assert [kind.sensors for kind in kinds] == [(0, 2, 3, 4), (1,), (5,)]
    assert [kind.name for kind in kinds] == ["rangers", "rangers", "srf08"]


def test_the_same_log_and_seed_tell_the_same() -> None:
    recording = sensor_logs.log(30.0)
    pings = reference_map.placed(recording)
    first, again = (sensor_calibration.results(recording, pings, sensor_logs.room(), 1) for _ in range(2))
    assert repr(first) == repr(again)


def test_the_formula_of_these_tests_gives_the_angles_that_the_transducer_s_description_has() -> None:
    assert degrees(acoustic_half_angle(0.8)) == pytest.approx(30.0, abs=0.1)
    assert degrees(acoustic_half_angle(2.0)) == pytest.approx(25.0, abs=1.0)
    assert degrees(acoustic_half_angle(4.5)) == pytest.approx(15.0, abs=1.0)
