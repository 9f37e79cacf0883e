from dataclasses import replace
from math import asin, cos, degrees, pi, radians

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from echogrid.emulation import acoustics, piston, transducers
from echogrid.emulation.ear import ear

C20 = acoustics.speed_of_sound(20.0)
POLAROID_KA = piston.wave_number_times_radius(0.0192, 49_400.0, C20)
CAPSULE_KA = piston.wave_number_times_radius(0.0075, 40_000.0, C20)


def test_speed_of_sound_follows_the_temperature():
    speeds = [acoustics.speed_of_sound(t) for t in (-10, 0, 20, 40)]
    assert speeds == pytest.approx([325.17902206082, 331.3, 343.21462268256795, 354.7292833221906], abs=1e-6)


def test_a_fixed_speed_of_sound_misjudges_ranges():
    errors = [4.0 * (343.2 / acoustics.speed_of_sound(t) - 1.0) for t in (0, 40)]
    assert errors == pytest.approx([0.14367642619981869, -0.13000655840097552], abs=1e-6)


def test_time_of_flight_becomes_range():
    assert acoustics.range_of_flight(5830e-6, 20.0) == pytest.approx(1.0004706251196855, abs=1e-6)
    assert acoustics.range_of_flight(5830e-6, 0.0) == pytest.approx(0.9657395, abs=1e-6)


def test_a_ping_and_its_echo_take_their_time():
    """One sonar of 6 m reach, sixteen one after the other, four groups of four."""
    assert acoustics.range_of_flight(34.96354527731923e-3, 20.0) == pytest.approx(6.0, abs=1e-6)
    assert acoustics.range_of_flight(0.5594167244371077, 20.0) == pytest.approx(16 * 6.0, abs=1e-6)
    assert acoustics.range_of_flight(139.8541811092769e-3, 20.0) == pytest.approx(4 * 6.0, abs=1e-6)


def test_a_beam_covers_a_stretch_of_wall():
    """12.7 deg to either side, at 2 m."""
    null_angle = radians(12.7) / piston.plane_beam_half_width(1.0, transducers.POLAROID.sensitivity)
    fan = ear(replace(transducers.POLAROID, null_angle=null_angle), 30.0)
    assert 2.0 * 2.0 * fan.fan_slope == pytest.approx(0.9014389319873812, abs=1e-6)


@given(st.floats(0.05, 20.0), st.floats(0.05, 20.0))
def test_what_scatters_halfway_takes_what_it_takes_of_an_echo(there, back):
    assert acoustics.harmonic_mean(there, there) == pytest.approx(there)
    assert acoustics.harmonic_mean(there, back) == acoustics.harmonic_mean(back, there)
    assert min(there, back) <= acoustics.harmonic_mean(there, back) * (1.0 + 1e-12)
    assert acoustics.harmonic_mean(there, back) <= max(there, back) * (1.0 + 1e-12)


@given(st.floats(-1.5, 1.5))
def test_both_ways_through_a_beam_take_twice_what_one_does(bearing):
    null_angle = transducers.SRF08.null_angle
    there_and_back = 2.0 * acoustics.one_way_beam_loss(bearing, null_angle)
    assert there_and_back == pytest.approx(acoustics.beam_loss(bearing, null_angle), rel=1e-12)


@pytest.mark.parametrize(
    ("radius", "frequency", "ka", "null", "half_power", "kuc", "wavelength"),
    [
        (
            0.0192,
            49_400.0,
            17.363699581254405,
            12.748565676803157,
            5.332629868169852,
            12.752094449943403,
            6.94766442677263,
        ),
        (
            0.0075,
            40_000.0,
            5.49206084933401,
            44.24115041106159,
            17.087490070857967,
            44.25634125058676,
            8.580365567064199,
        ),
    ],
)
def test_the_beam_of_known_capsules(radius, frequency, ka, null, half_power, kuc, wavelength):
    computed = piston.wave_number_times_radius(radius, frequency, C20)
    assert computed == pytest.approx(ka, abs=1e-6)
    assert degrees(asin(3.8317 / computed)) == pytest.approx(null, abs=1e-6)  # the vector rounds J1's zero
    assert degrees(piston.first_null(computed)) == pytest.approx(null, abs=1e-4)
    assert degrees(piston.half_power_angle(computed)) == pytest.approx(half_power, abs=1e-6)
    assert degrees(piston.kuc_null_angle(radius, frequency, C20)) == pytest.approx(kuc, abs=1e-6)
    assert 1e3 * acoustics.wavelength(frequency, C20) == pytest.approx(wavelength, abs=1e-6)


def test_the_beam_vanishes_at_its_null_and_is_one_on_the_axis():
    for ka in (POLAROID_KA, CAPSULE_KA):
        assert piston.directivity(ka, piston.first_null(ka)) == pytest.approx(0.0, abs=1e-12)
        assert piston.directivity(ka, 0.0) == 1.0


@given(st.floats(-59.0, 59.0))
def test_j1_solves_bessels_equation(x):
    """x^2 J'' + x J' + (x^2 - 1) J = 0, with J' and J'' by central differences."""
    step = 1e-3
    before, here, after = piston.bessel_j1([x - step, x, x + step])
    slope, bend = (after - before) / (2 * step), (after - 2 * here + before) / step**2
    assert x**2 * bend + x * slope + (x**2 - 1) * here == pytest.approx(0.0, abs=1e-5 * (1 + x**2))


def test_j1_agrees_with_the_tables():
    table = {0.0: 0.0, 1.0: 0.4400505857449335, 2.0: 0.5767248077568734, 10.0: 0.04347274616886144}
    assert piston.bessel_j1(list(table)) == pytest.approx(list(table.values()), abs=1e-9)


def test_the_two_way_beam_of_kuc():
    losses = acoustics.beam_loss(np.radians([5.0, 10.0, 15.0]), transducers.POLAROID.null_angle)
    assert -losses == pytest.approx([-5.34135281430183, -21.365411257207324, -48.07217532871647], abs=1e-6)


def test_spreading_from_1_m_to_4_m():
    exponents = (acoustics.PLANE_SPREADING, acoustics.EDGE_SPREADING, acoustics.POINT_SPREADING)
    losses = [float(acoustics.spreading_loss(np.array(4.0), exponent)) for exponent in exponents]
    assert losses == pytest.approx([12.041199826559248, 18.06179973983887, 24.082399653118497], abs=1e-6)


def test_roughness_which_scatters():
    length = acoustics.wavelength(49_400.0, C20)
    heights = [1e3 * acoustics.rayleigh_height(length, radians(i)) for i in (0, 45, 70)]
    assert heights == pytest.approx([0.8684580533465788, 1.2281851573948686, 2.5392014777317957], abs=1e-6)


@given(st.floats(0.1, 10.0), st.floats(0.01, 3.0))
def test_a_thicker_or_nearer_cylinder_loses_less(distance, radius):
    loss = acoustics.cylinder_loss(np.array(distance), np.array(radius))
    assert loss > 0.0
    assert acoustics.cylinder_loss(np.array(2 * distance), np.array(radius)) > loss
    assert acoustics.cylinder_loss(np.array(distance), np.array(2 * radius)) < loss


def test_a_rough_facet_follows_lambert():
    losses = acoustics.rough_loss(np.array([1.0, cos(pi / 3)]))
    assert losses == pytest.approx([14.0, 14.0 + 6.020599913])


def test_the_gain_ramp_makes_a_wall_equally_loud_up_to_its_end():
    losses = transducers.A02YYUW.range_loss(np.array([0.1, 0.5, 1.0, 2.0, 4.0]))
    assert losses[:3] == pytest.approx([0.0, 0.0, 0.0])
    assert losses[3:] == pytest.approx([6.0205999 + 2.6, 12.0411998 + 7.8])


def _visible_at(transducer, distance):
    left = transducer.sensitivity - float(transducer.range_loss(np.array(distance)))
    return degrees(piston.plane_beam_half_width(transducer.null_angle, left))


def test_the_beams_are_as_wide_as_their_texts_say():
    assert _visible_at(transducers.POLAROID, 5.0) == pytest.approx(11.85, abs=0.01)
    assert _visible_at(transducers.SRF08, 2.0) == pytest.approx(25.0, abs=1.0)
    assert _visible_at(transducers.SRF08, 0.39) == pytest.approx(41.0, abs=0.5)
    assert _visible_at(transducers.SRF08, 4.1) == 0.0
    assert _visible_at(transducers.A02YYUW, 0.9) == pytest.approx(30.0, abs=0.1)
    assert _visible_at(transducers.A02YYUW, 2.0) == pytest.approx(25.0, abs=1.0)
    assert _visible_at(transducers.A02YYUW, 4.5) == pytest.approx(15.0, abs=1.0)


@pytest.mark.parametrize("transducer", [transducers.POLAROID, *transducers.TRANSDUCERS.values()])
@given(distance=st.floats(1e-3, 12.0))
def test_an_ear_reckons_with_the_transducers_own_loss_to_the_bit(transducer, distance):
    heard = ear(transducer, transducer.sensitivity)
    for metres in (distance, transducer.ramp_end):
        assert heard.range_loss(metres) == transducer.range_loss(metres)
