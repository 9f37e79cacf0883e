"""Maps of a map_server, read for driving by them."""

from pathlib import Path

import numpy as np
import pytest

from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.long_term_map import MapImage
from echogrid.runtime import map_files, map_reading
from echogrid.runtime.errors import UsageError

YAML = """# a floor
image: floor.pgm
resolution: 0.1
origin: [-1.0, 2.0, 0.0]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.196
"""
PGM = b"P5\n3 2\n255\n" + bytes((0, 254, 205, 254, 254, 0))
"""Row 0 is the northern one: wall, floor, unknown; then floor, floor, wall."""


def written(folder: Path, yaml: str = YAML, pgm: bytes = PGM) -> Path:
    (folder / "floor.pgm").write_bytes(pgm)
    (folder / "map.yaml").write_text(yaml)
    return folder / "map.yaml"


def test_pixels_are_walls_floor_or_neither_from_the_south(tmp_path: Path) -> None:
    known = map_reading.read(written(tmp_path))
    assert known.occupied.tolist() == [[False, False, True], [True, False, False]]
    assert known.free.tolist() == [[True, True, False], [False, True, False]]
    assert (known.resolution, known.origin.x, known.origin.y) == (0.1, -1.0, 2.0)
    assert known.cell(-0.75, 2.05) == (0, 2)
    assert known.cell(-1.05, 2.05) is None


def test_a_folder_stands_for_its_map_yaml_and_a_list_may_have_lines_of_its_own(tmp_path: Path) -> None:
    plain = map_reading.read(written(tmp_path))
    listed = YAML.replace("origin: [-1.0, 2.0, 0.0]", "origin:\n- -1.0\n- 2.0\n- 0.0")
    written(tmp_path, listed)
    again = map_reading.read(tmp_path)
    assert again.origin == plain.origin
    assert np.array_equal(again.occupied, plain.occupied)


def test_a_negated_picture_has_walls_where_it_is_bright(tmp_path: Path) -> None:
    turned = bytes(255 - pixel for pixel in PGM[-6:])
    written(tmp_path, YAML.replace("negate: 0", "negate: 1"), PGM[:-6] + turned)
    assert map_reading.read(tmp_path).occupied.tolist() == [[False, False, True], [True, False, False]]


def test_an_origin_that_is_turned_turns_the_plan(tmp_path: Path) -> None:
    written(tmp_path, YAML.replace("[-1.0, 2.0, 0.0]", "[0.0, 0.0, 1.5707963267948966]"))
    known = map_reading.read(tmp_path)
    assert known.cell(-0.05, 0.25) == (0, 2)
    walls = {tuple(point) for point in np.round(known.floor_plan().walls, 9).tolist()}
    assert {(-0.05, 0.25), (-0.15, 0.05)} <= walls


def test_a_map_of_ours_is_read_as_it_was_written(tmp_path: Path) -> None:
    geometry = GridGeometry(0.1, -0.5, 0.3, 4, 5)
    occupancy = np.full(geometry.shape, 0.5, np.float32)
    occupancy[1, 2], occupancy[3, 4], occupancy[0] = 0.9, 0.7, 0.05
    unknown = np.zeros(geometry.shape, np.bool_)
    map_files.write(tmp_path, MapImage(geometry, occupancy, unknown, {}), [])
    known = map_reading.read(tmp_path)
    assert np.array_equal(known.occupied, occupancy > 0.65)
    assert np.array_equal(known.free, occupancy < 0.196)
    assert (known.origin.x, known.origin.y) == (-0.5, 0.3)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("resolution: 0.1", "resolution: wide", "map.yaml:3: resolution: 'wide' is no number"),
        ("resolution: 0.1", "resolution: 0", "resolution must be above 0"),
        ("origin: [-1.0, 2.0, 0.0]", "origin: [1, 2]", "map.yaml:4: origin must be x, y (m) and yaw"),
        ("image: floor.pgm", "image: other.pgm", "other.pgm: no such file"),
        ("image: floor.pgm\n", "", "lacks 'image': add a line `image: map.pgm`"),
        ("negate: 0", "negate: maybe", "map.yaml:5: negate: 'maybe' is neither 0 nor 1"),
        ("negate: 0", "negate 0", "is no `key: value`"),
        ("negate: 0", "resolution: 0.2", "map.yaml:5: resolution stands in line 3 already"),
        ("free_thresh: 0.196", "free_thresh: 0.9", "must lie in 0...1"),
        ("negate: 0", "mode: raw", "mode 'raw' can't be read"),
    ],
)
def test_what_is_wrong_is_told_with_its_line_and_a_mend(
    tmp_path: Path, old: str, new: str, told: str
) -> None:
    with pytest.raises(UsageError) as error:
        map_reading.read(written(tmp_path, YAML.replace(old, new)))
    (line,) = error.value.problems
    assert told in line


def test_no_map_and_no_picture_are_told(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="no such file"):
        map_reading.read(tmp_path / "nowhere")
    with pytest.raises(UsageError, match=r"floor\.pgm"):
        map_reading.read(written(tmp_path, pgm=b"no picture"))
