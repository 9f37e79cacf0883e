from math import degrees, radians

import pytest

from echogrid.emulation import transducers
from echogrid.emulation.models import RANGERS
from echogrid.emulation.piston import null_angle_of_beam, plane_beam_half_width
from echogrid.emulation.transducers import POLAROID, SRF08, SRF235, TRANSDUCERS


def test_every_emulated_ranger_has_its_transducer():
    assert set(RANGERS) <= set(TRANSDUCERS)


def test_the_beam_in_a_polaroid_s_data_sheet_is_that_of_its_radius():
    """15 deg at -6 dB."""
    assert null_angle_of_beam(radians(15.0)) == pytest.approx(POLAROID.null_angle, abs=radians(0.02))


TURNED_DOWN = ("srf08", "srf10")
"""Their chips are set to hear less far than their data sheets promise."""


@pytest.mark.parametrize("model", [model for model in TRANSDUCERS if model not in TURNED_DOWN])
def test_a_wall_on_the_axis_is_heard_to_the_reach_with_a_few_db_to_spare(model):
    transducer = TRANSDUCERS[model]
    assert 0.0 <= transducer.sensitivity - transducer.range_loss(transducer.reach) <= 16.0


@pytest.mark.parametrize("model", TRANSDUCERS)
def test_no_wall_is_heard_louder_than_at_the_end_of_the_ramp(model):
    transducer = TRANSDUCERS[model]
    ranges = [0.05 * transducer.reach * step for step in range(1, 21)]
    losses = [transducer.range_loss(distance) for distance in ranges]
    assert losses == sorted(losses)
    for distance in ranges:
        assert transducer.ramp_loss(distance) >= 0.0
        assert transducer.way_loss(distance) + transducer.ramp_loss(distance) == pytest.approx(
            transducer.range_loss(distance)
        )


def _half_width(transducer, distance):
    left = transducer.sensitivity - transducer.range_loss(distance)
    return degrees(plane_beam_half_width(transducer.null_angle, left))


def test_a_235_khz_pencil_hears_no_wall_beyond_8_or_9_deg():
    assert 8.0 <= _half_width(SRF235, 0.2) <= 9.0
    assert _half_width(SRF235, 1.19) < 2.0


def test_wider_beams_are_wider():
    at_2_m = [
        _half_width(TRANSDUCERS[model], 2.0)
        for model in ("urm12", "i2cxl", "iio", "maxbotix", "srf02", "urm13")
    ]
    assert at_2_m == sorted(at_2_m)


def test_bands_are_mutual_and_40_khz_rangers_are_all_in_one():
    for first in TRANSDUCERS.values():
        for second in TRANSDUCERS.values():
            assert first.hears(second.frequency) == second.hears(first.frequency)
    deaf_to_40_khz = {name for name, each in TRANSDUCERS.items() if not each.hears(SRF08.frequency)}
    assert deaf_to_40_khz == {"srf235", "urm14", "urm15"}


def test_the_narrow_and_the_wide_maxsonar_differ_in_nothing_else():
    narrow, wide = transducers.MAXBOTIX_NARROW, transducers.MAXBOTIX_WIDE
    assert wide.null_angle > 2.0 * narrow.null_angle
    assert (wide.reach, wide.frequency) == (narrow.reach, narrow.frequency) == (7.65, 42_000.0)
