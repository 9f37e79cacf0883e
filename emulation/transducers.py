"""The transducers that the emulated devices carry.

A data sheet's beam ends where the capsule alone has lost 6 dB to either side. A large smooth wall is heard
over 1.6 times that angle while the gain ramp lasts, and over less further off. On the axis it is heard to the
reach in the data sheet, with a few dB to spare. What becomes of echoes from too near is for devices to say.
"""

from collections.abc import Mapping
from dataclasses import replace
from math import radians

from echogrid.emulation.acoustics import Transducer, speed_of_sound
from echogrid.emulation.piston import kuc_null_angle, null_angle_of_beam

_SPEED_AT_20 = speed_of_sound(20.0)

POLAROID = Transducer(
    null_angle=kuc_null_angle(0.0192, 49_400.0, _SPEED_AT_20),
    sensitivity=30.0,
    blanking=0.15,
    reach=10.7,
    level_range=10.7,
    ramp_end=10.7,
    absorption=1.6,
    frequency=49_400.0,
)
"""Electrostatic, 49.4 kHz, with the 6500 board: gain steps all the way to 35 ft, blanking cut to 6 in."""

SRF08 = Transducer(
    null_angle=kuc_null_angle(0.0075, 40_000.0, _SPEED_AT_20),
    sensitivity=30.0,
    blanking=0.0,
    reach=6.0,
    level_range=0.39,
    ramp_end=0.01,
    absorption=1.3,
    frequency=40_000.0,
)
"""Open 16 mm capsules, 40 kHz. The chip itself applies its gain ramp and makes of near echoes what it can.

With 30 dB a smooth wall is heard to 41 deg at 0.4 m, to 25 deg at 2 m and on the axis to 4 m. That is 10 dB
short of the 6 m in its data sheet: users turn it down so far, or the floor and every door frame answers.
"""

SRF10 = replace(SRF08, null_angle=null_angle_of_beam(radians(72.0)))
"""Two 10 mm capsules, 40 kHz, 72 deg (unverified). Its gain ramp is the chip's, too, and so is its reach."""

SRF02 = Transducer(
    null_angle=null_angle_of_beam(radians(55.0)),
    sensitivity=30.0,
    blanking=0.0,
    reach=6.0,
    level_range=1.5,
    ramp_end=1.5,
    absorption=1.3,
    frequency=40_000.0,
)
"""One capsule for both ways, 40 kHz, 55 deg, 6 m."""

SRF01 = SRF02
"""The same capsule on one pin."""

SRF235 = Transducer(
    null_angle=radians(9.15),
    sensitivity=30.0,
    blanking=0.0,
    reach=1.2,
    level_range=0.32,
    ramp_end=0.32,
    absorption=10.0,
    frequency=235_000.0,
)
"""A 235 kHz pencil: a flat surface is heard to 8.5 deg and not beyond ("8-9 deg" in its data sheet).

The air takes ten times as much as at 40 kHz, so that a wall on the axis is just heard at the 1.2 m of its
data sheet, a post at 1 m is not, and nothing else of the robot is ever heard at all.
"""

MAXBOTIX_NARROW = Transducer(
    null_angle=null_angle_of_beam(radians(20.0)),
    sensitivity=30.0,
    blanking=0.0,
    reach=7.65,
    level_range=2.5,
    ramp_end=2.5,
    absorption=1.35,
    frequency=42_000.0,
)
"""A MaxSonar of the narrow kind (EZ4), 42 kHz, 7.65 m. Beams depend on the part; this one is typical."""

MAXBOTIX_WIDE = replace(MAXBOTIX_NARROW, null_angle=null_angle_of_beam(radians(45.0)))
"""A MaxSonar of the wide kind (EZ0, EZ1)."""

HC_SR04 = Transducer(
    null_angle=null_angle_of_beam(radians(40.0)),
    sensitivity=30.0,
    blanking=0.0,
    reach=4.0,
    level_range=1.0,
    ramp_end=1.0,
    absorption=1.3,
    frequency=40_000.0,
)
"""Two open 16 mm capsules, 40 kHz, 4 m. The 15 deg in its data sheet hold for small targets only."""

RCWL_9620 = replace(HC_SR04, reach=4.5)
"""The same capsules (20 deg to either side) behind another chip, 4.5 m."""

PING = replace(HC_SR04, reach=3.0)
"""Parallax's, 3 m; 40 deg (unverified)."""

A02YYUW = Transducer(
    null_angle=radians(32.3),
    sensitivity=30.0,
    blanking=0.0,
    reach=4.5,
    level_range=1.0,
    ramp_end=1.0,
    absorption=1.3,
    frequency=40_000.0,
)
"""Closed 40 kHz capsule: heard 30 deg to either side (the 60 deg of its data sheet) while the ramp lasts.

A wall is heard to 25 deg at 2 m and 15 deg at the 4.5 m which are its reach.
"""

URM09 = Transducer(
    null_angle=null_angle_of_beam(radians(60.0)),
    sensitivity=30.0,
    blanking=0.0,
    reach=5.0,
    level_range=1.2,
    ramp_end=1.2,
    absorption=1.3,
    frequency=40_000.0,
)
"""Two open capsules, 40 kHz, 60 deg, 5 m."""

URM07 = replace(URM09, reach=7.5, level_range=2.2, ramp_end=2.2)
"""One closed capsule for both ways, 40 kHz, 60 deg, 7.5 m."""

URM37 = replace(URM09, reach=8.0, level_range=2.5, ramp_end=2.5)
"""Two open capsules, 40 kHz, 60 deg (unverified), 8 m."""

URM13 = replace(URM09, reach=9.0, level_range=3.0, ramp_end=3.0)
"""One closed capsule, 40 kHz, 60 deg, 9 m."""

URM12 = replace(
    URM09,
    null_angle=null_angle_of_beam(radians(15.0)),
    blanking=0.0,
    reach=15.0,
    level_range=7.5,
    ramp_end=7.5,
)
"""A horn, 40 kHz, 15 deg, 0.7 to 15 m."""

URM14 = Transducer(
    null_angle=null_angle_of_beam(radians(12.0)),
    sensitivity=30.0,
    blanking=0.0,
    reach=1.5,
    level_range=0.5,
    ramp_end=0.5,
    absorption=8.0,
    frequency=200_000.0,
)
"""200 kHz, 12 deg, 1.5 m."""

URM15 = Transducer(
    null_angle=null_angle_of_beam(radians(20.0)),
    sensitivity=30.0,
    blanking=0.0,
    reach=5.0,
    level_range=1.7,
    ramp_end=1.7,
    absorption=2.4,
    frequency=75_000.0,
)
"""Closed 75 kHz capsule, 20 deg, 5 m (unverified)."""

TRANSDUCERS: Mapping[str, Transducer] = {
    "srf01": SRF01,
    "srf02": SRF02,
    "srf02-serial": SRF02,
    "srf08": SRF08,
    "srf10": SRF10,
    "srf235": SRF235,
    "i2cxl": MAXBOTIX_NARROW,
    "maxbotix": MAXBOTIX_WIDE,
    "urm07": URM07,
    "urm09": URM09,
    "urm12": URM12,
    "urm13": URM13,
    "urm13-i2c": URM13,
    "urm14": URM14,
    "urm15": URM15,
    "urm37": URM37,
    "rcwl-9620": RCWL_9620,
    "a02yyuw": A02YYUW,
    "dyp-rs485": A02YYUW,
    "ff-on-demand": A02YYUW,
    "ping": PING,
    "iio": HC_SR04,
}
"""By the model of the device. Behind the kernel's drivers ("iio") it is most often an HC-SR04."""
