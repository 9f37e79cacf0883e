from math import atan2, cos, degrees, radians, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.wall_faces import WallFaces, faces_of
from echogrid.mapping.wall_refinement import WallEcho, refined

GEOMETRY = GridGeometry.covering(-3.0, -3.0, 3.0, 3.0, 0.1)


def distance_to(normal: tuple[float, float], offset: float) -> np.ndarray:
    """(rows, cols) m, of each cell's centre from a line, above 0 on its normal's side."""
    x, y = np.meshgrid(GEOMETRY.x_centres, GEOMETRY.y_centres)
    return x * normal[0] + y * normal[1] - offset


def turned_by(faces: WallFaces, normal: tuple[float, float]) -> np.ndarray:
    """(n,) deg: by what the faces' normals differ from one; those that look the other way are left out."""
    mine = faces.normals[faces.normals @ normal > 0.0]
    return np.array([degrees(atan2(n[1] * normal[0] - n[0] * normal[1], n @ normal)) for n in mine])


@settings(deadline=None)
@given(st.floats(-180.0, 180.0), st.floats(-0.5, 0.5))
def test_a_straight_wall_has_faces_on_it_that_look_straight_at_its_two_sides(
    bearing_deg: float, offset: float
) -> None:
    normal = cos(radians(bearing_deg)), sin(radians(bearing_deg))
    faces = faces_of(GEOMETRY, np.abs(distance_to(normal, offset)) <= 0.07)
    x, y = faces.middles.T
    assert np.all(np.abs(x * normal[0] + y * normal[1] - offset) < 0.2)
    inner = np.hypot(x, y) < 1.5
    turns = turned_by(WallFaces(GEOMETRY, faces.solid, *(each[inner] for each in _parts(faces))), normal)
    assert len(turns) > 5
    assert np.median(np.abs(turns)) < 6.0


def _parts(faces: WallFaces) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return faces.cells, faces.middles, faces.normals


def test_a_lone_cell_or_a_post_has_no_face() -> None:
    occupied = np.zeros(GEOMETRY.shape, np.bool_)
    occupied[20, 20] = occupied[40, 40] = occupied[40, 41] = True
    assert len(faces_of(GEOMETRY, occupied).cells) == 0
    assert len(faces_of(GEOMETRY, np.zeros(GEOMETRY.shape, np.bool_)).cells) == 0


def echoes_of(faces: WallFaces, normal: np.ndarray, offset: float, noise: float, seed: int) -> list[WallEcho]:
    """What is heard of the line n p = offset from places before it, each by the face next to its foot."""
    random = np.random.default_rng(seed)
    found = []
    for _ in range(200):
        place = random.uniform(-1.5, 1.5, 2)
        reading = float(place @ normal - offset)
        if reading > 0.2:
            foot = place - reading * normal
            apart = np.hypot(*(faces.cells - foot).T)
            face = int(np.argmin(np.where(faces.normals @ normal > 0.0, apart, np.inf)))
            found.append(WallEcho(face, *place, reading + noise * float(random.standard_normal())))
    return found


@settings(deadline=None, max_examples=25)
@given(st.floats(-4.0, 4.0), st.floats(-0.04, 0.04), st.integers(0, 99))
def test_echoes_draw_a_wall_finer_than_its_cells(turn_deg: float, shift: float, seed: int) -> None:
    faces = faces_of(GEOMETRY, np.abs(distance_to((0.0, 1.0), -1.7)) <= 0.07)
    true = np.array((-sin(radians(turn_deg)), cos(radians(turn_deg))))
    drawn = faces
    for _ in range(2):
        drawn = refined(drawn, echoes_of(drawn, true, -1.7 + shift, 0.01, seed))
    near = np.abs(drawn.cells[:, 0]) < 0.8
    assert near.sum() > 5
    off = np.abs(drawn.middles[near] @ true - (-1.7 + shift))
    assert np.median(off) < 0.015
    assert np.median(np.abs(turned_by(drawn, tuple(true)))) < 1.5


def test_a_wall_that_too_few_echoes_draw_is_left_out() -> None:
    faces = faces_of(GEOMETRY, np.abs(distance_to((0.0, 1.0), -1.7)) <= 0.07)
    echoes = echoes_of(faces, np.array((0.0, 1.0)), -1.7, 0.01, 1)
    assert len(refined(faces, []).cells) == 0
    assert len(refined(faces, echoes[:3]).cells) == 0
    assert len(refined(faces, echoes * 3).cells) > 10


def test_echoes_that_are_of_no_line_draw_none() -> None:
    faces = faces_of(GEOMETRY, np.abs(distance_to((0.0, 1.0), -1.7)) <= 0.07)
    ghosts = echoes_of(faces, np.array((0.0, 1.0)), -1.7, 0.3, 1)
    assert len(refined(faces, ghosts).cells) == pytest.approx(0, abs=2)
