"""Footprints to try things with: boxes, an L, a T, and stars of any shape."""

from math import cos, sin, tau

from hypothesis import strategies as st

from echogrid.mapping.footprint import Footprint

BOX = Footprint.box(-0.2, 0.2, 0.15)
ELL = Footprint([(-0.2, -0.15), (0.3, -0.15), (0.3, 0.0), (0.1, 0.05), (0.1, 0.2), (-0.2, 0.2)])
TEE = Footprint(
    [(0.2, 0.3), (-0.2, 0.3), (-0.2, 0.2), (0.0, 0.2), (0.0, -0.2), (-0.2, -0.2), (-0.2, -0.3), (0.2, -0.3)]
)


def star(reaches: list[float]) -> Footprint:
    """Corners at even angles around base_link, at those distances (m)."""
    angles = [tau * k / len(reaches) for k in range(len(reaches))]
    return Footprint([(r * cos(a), r * sin(a)) for r, a in zip(reaches, angles, strict=True)])


stars = st.lists(st.floats(0.08, 0.6), min_size=3, max_size=9).map(star)
outlines = st.sampled_from([BOX, ELL, TEE]) | stars
