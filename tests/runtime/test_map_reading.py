from math import pi
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from echogrid.mapping.pose import Pose
from echogrid.runtime import map_files, map_reading
from echogrid.runtime.errors import UsageError

from .maps import image

YAML = """\
image: picture.pgm
resolution: 0.050000
origin: [-1.5, 2.000000, 0.250000]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.196
"""
PICTURE = b"P2\n# by hand\n3 2\n255\n0 254 205\n254 0 0\n"
OCCUPIED = [[False, True, True], [True, False, False]]
FREE = [[True, False, False], [False, True, False]]


@pytest.fixture
def path(tmp_path: Path) -> Path:
    (tmp_path / "picture.pgm").write_bytes(PICTURE)
    (tmp_path / "floor.yaml").write_text(YAML)
    return tmp_path / "floor.yaml"


def is_the_map(path: Path) -> bool:
    known = map_reading.read(path)
    masks = known.occupied.tolist() == OCCUPIED and known.free.tolist() == FREE
    return masks and (known.resolution, known.origin) == (0.05, Pose(-1.5, 2.0, 0.25))


def test_a_map_of_a_map_server_is_read_with_its_yaw_and_its_first_row_in_the_north(path: Path) -> None:
    assert is_the_map(path)


def test_plain_and_binary_pictures_say_the_same(path: Path) -> None:
    path.with_name("picture.pgm").write_bytes(b"P5 3 2 255\n" + bytes((0, 254, 205, 254, 0, 0)))
    assert is_the_map(path)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("image: picture.pgm", 'image:   "picture.pgm"   # drawn'),
        ("image", "---\n\n# a comment: of words\n'image'"),
        ("\n", "\r\n"),
        ("origin: [-1.5, 2.000000, 0.250000]", "origin:\n- -1.5\n- 2.0\n  # yaw\n- 0.25"),
        ("origin: [-1.5, 2.000000, 0.250000]", "origin:\n  - -1.5\n  - 2.0\n  - 0.25"),
        ("occupied_thresh: 0.65\n", ""),
        ("negate: 0", "negate: false\nmode: trinary\nmade_by: somebody"),
        ("negate: 0\n", "mode: scale\n"),
    ],
)
def test_what_others_write_in_other_words_is_the_same_map(path: Path, old: str, new: str) -> None:
    path.write_bytes(YAML.replace(old, new).encode())
    assert is_the_map(path)


def test_a_negated_map_is_read_the_other_way_round(path: Path) -> None:
    path.write_text(YAML.replace("negate: 0", "negate: 1"))
    path.with_name("picture.pgm").write_bytes(b"P2 3 2 255 255 1 50 1 255 255")
    assert is_the_map(path)


def test_the_picture_may_be_elsewhere_and_the_map_named_by_its_folder(path: Path, tmp_path: Path) -> None:
    (tmp_path / "maps").mkdir()
    (tmp_path / "maps/map.yaml").write_text(YAML.replace("picture", "../picture"))
    assert is_the_map(tmp_path / "maps")
    (tmp_path / "maps/map.yaml").write_text(YAML.replace("picture", f"{tmp_path}/picture"))
    assert is_the_map(tmp_path / "maps")


def test_the_map_that_we_write_is_read_back(tmp_path: Path) -> None:
    made = image([[0.0, 1.0, float("nan")], [1.0, 0.0, 0.0]])
    map_files.write(tmp_path, made, [])
    known = map_reading.read(tmp_path)
    assert known.occupied.tolist() == [[False, True, False], [True, False, False]]
    assert known.free.tolist() == [[True, False, False], [False, True, True]]
    assert (known.resolution, known.origin) == (0.5, Pose(-1.0, 2.0))


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("resolution: 0.050000", "resolution 0.05", "floor.yaml:2: 'resolution 0.05' is no `key: value`"),
        ("resolution: 0.050000", "  resolution: 0.05", "floor.yaml:2: 'resolution: 0.05' is no `key: value`"),
        ("resolution: 0.050000", "resolution:0.05", "floor.yaml:2: 'resolution:0.05' is no `key: value`"),
        ("resolution: 0.050000", "- 0.05", "floor.yaml:2: '- 0.05' is no `key: value`"),
        ("resolution: 0.050000", "image: b.pgm", "floor.yaml:2: image stands in line 1 already: keep one"),
        ("resolution: 0.050000\n", "", "floor.yaml: lacks 'resolution': add a line `resolution: 0.05`"),
        ("resolution: 0.050000", "resolution: 0", "floor.yaml:2: resolution must be above 0"),
        ("resolution: 0.050000", "resolution: nan", "floor.yaml:2: resolution must be above 0"),
        ("resolution: 0.050000", "resolution: 5 cm", "floor.yaml:2: resolution: '5 cm' is no number"),
        (", 0.250000]", "]", "floor.yaml:3: origin must be x, y (m) and yaw (rad), as [-10.0, -10.0, 0.0]"),
        ("0.250000]", "inf]", "floor.yaml:3: origin must be x, y (m) and yaw (rad)"),
        ("negate: 0", "negate: maybe", "floor.yaml:4: negate: 'maybe' is neither 0 nor 1"),
        ("negate: 0", "mode: raw", "floor.yaml:4: mode 'raw' can't be read: save the map as trinary"),
        (
            "free_thresh: 0.196",
            "free_thresh: 0.8",
            "floor.yaml:6: free_thresh and occupied_thresh must",
        ),
        ("picture.pgm", "gone.pgm", "gone.pgm: no such file"),
        ("picture.pgm", "floor.yaml", "floor.yaml: is neither a PGM nor a PNG"),
    ],
)
def test_what_is_wrong_is_one_line_that_names_file_line_and_mend(
    path: Path, old: str, new: str, told: str
) -> None:
    path.write_text(YAML.replace(old, new))
    with pytest.raises(UsageError) as raised:
        map_reading.read(path)
    assert told in str(raised.value)
    assert len(raised.value.problems) == 1


def test_a_map_that_is_not_there_is_told(tmp_path: Path) -> None:
    for gone in (tmp_path, tmp_path / "map.yaml"):
        with pytest.raises(UsageError, match=r"map\.yaml: no such file"):
            map_reading.read(gone)


@given(st.binary(max_size=200) | st.text(max_size=200).map(str.encode))
def test_whatever_a_file_holds_is_a_map_or_one_line(tmp_path_factory, data: bytes) -> None:
    folder = tmp_path_factory.getbasetemp() / "whatever"
    folder.mkdir(exist_ok=True)
    (folder / "picture.pgm").write_bytes(PICTURE)
    for text in (data, YAML.encode() + data):
        (folder / "map.yaml").write_bytes(text)
        try:
            known = map_reading.read(folder)
            assert known.occupied.shape == known.free.shape
            assert not (known.occupied & known.free).any()
            assert np.isfinite((known.origin.x, known.origin.y, known.origin.yaw)).all()
        except UsageError as error:
            assert len(error.problems) == 1
            assert "\n" not in error.problems[0]


def test_a_quarter_turn_puts_the_north_in_the_west(path: Path) -> None:
    path.write_text(YAML.replace("[-1.5, 2.000000, 0.250000]", f"[0.0, 0.0, {pi / 2.0!r}]"))
    known = map_reading.read(path)
    assert known.cell(-0.075, 0.025) == (1, 0)
    assert known.occupied[1, 0]
