from pathlib import Path
from typing import Any
from zipfile import ZIP_DEFLATED, ZipFile

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from echogrid.mapping.grid import GridGeometry
from echogrid.runtime import map_files, png, truth_map
from echogrid.runtime.errors import UsageError
from echogrid.runtime.grey_image import read_grey
from echogrid.runtime.truth_map import TruthMap

from .maps import image

NAN = float("nan")
MAP = image([[0.0, 1.0, NAN], [1.0, 0.0, 0.0]], resolution=0.5, x=-1.0, y=2.0)
WALLS = [[False, True, False], [True, False, False]]
FREE = [[True, False, False], [False, True, True]]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Our own map files."""
    map_files.write(tmp_path, MAP, [])
    return tmp_path


def is_the_map(truth: TruthMap) -> bool:
    return truth.geometry == MAP.geometry and truth.walls.tolist() == WALLS and truth.free.tolist() == FREE


@pytest.mark.parametrize("name", ["map.yaml", "map.npz"])
def test_a_map_that_was_written_is_read_back(folder: Path, name: str) -> None:
    assert is_the_map(truth_map.read(folder / name))


def test_a_png_does_as_well_as_a_pgm(folder: Path) -> None:
    grey = read_grey((folder / "map.pgm").read_bytes())
    pixels = np.rint(np.repeat(grey[:, :, np.newaxis], 3, axis=2) * 255.0).astype(np.uint8)
    (folder / "map.png").write_bytes(png.encode(pixels))
    told = (folder / "map.yaml").read_text().replace("map.pgm", '"map.png"  # a picture')
    (folder / "map.yaml").write_text(told)
    assert is_the_map(truth_map.read(folder / "map.yaml"))


def test_negate_turns_black_and_white_round(folder: Path) -> None:
    pgm = (folder / "map.pgm").read_bytes()
    head, body = pgm[:-6], pgm[-6:]
    (folder / "map.pgm").write_bytes(head + bytes(255 - each for each in body))
    told = (folder / "map.yaml").read_text().replace("negate: 0", "negate: 1")
    (folder / "map.yaml").write_text(told)
    assert is_the_map(truth_map.read(folder / "map.yaml"))


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("image: map.pgm", "image: gone.pgm", "gone.pgm: no such file"),
        ("image: map.pgm\n", "", "lacks 'image'"),
        ("mode: trinary", "mode: raw", "mode 'raw' can't be read"),
        ("0.0]", "0.1]", "turned by 0.1 rad"),
        ("0.0]", "]", "origin: '' is no number"),
        (", 0.0]", "]", "origin must be x, y (m) and yaw (rad)"),
        ("-1.0,", "nan,", "origin must be x, y (m) and yaw (rad)"),
        ("-1.0,", "-inf,", "origin must be x, y (m) and yaw (rad)"),
        ("-1.0,", "1e300,", "origin must be x, y (m) and yaw (rad)"),
        ("0.0]", "nan]", "origin must be x, y (m) and yaw (rad)"),
        ("resolution: 0.5", "resolution: -1", "map.yaml:3: resolution must be above 0"),
        ("resolution: 0.5", "resolution: fine", "resolution: 'fine' is no number"),
        ("occupied_thresh: 0.65", "occupied_thresh: -1", "free_thresh and occupied_thresh must lie in 0...1"),
        ("free_thresh: 0.196", "free_thresh: 0.7", "free_thresh and occupied_thresh must lie in 0...1"),
        ("free_thresh: 0.196", "free_thresh: nan", "free_thresh and occupied_thresh must lie in 0...1"),
        ("image: map.pgm", "image:", ": no such file"),
        ("image: map.pgm", "image: /dev/zero", "/dev/zero: no such file"),
        ("image: map.pgm", "image: map.yaml", "is neither a PGM nor a PNG"),
    ],
)
def test_what_is_wrong_with_a_yaml_is_one_line(folder: Path, old: str, new: str, told: str) -> None:
    path = folder / "map.yaml"
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(UsageError) as raised:
        truth_map.read(path)
    assert told in str(raised.value)
    assert len(raised.value.problems) == 1


@pytest.mark.parametrize(("name", "data"), [("a.npz", b"x"), ("a.npz", b""), ("a.txt", b""), ("b.npz", None)])
def test_what_is_no_map_is_one_line(tmp_path: Path, name: str, data: bytes | None) -> None:
    if data is not None:
        (tmp_path / name).write_bytes(data)
    with pytest.raises(UsageError, match=name) as raised:
        truth_map.read(tmp_path / name)
    assert len(raised.value.problems) == 1


@pytest.fixture(scope="module")
def archive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Our own map.npz, to be damaged."""
    folder = tmp_path_factory.mktemp("archive")
    map_files.write(folder, MAP, [])
    return folder / "map.npz"


@given(st.lists(st.tuples(st.integers(0, 999_999), st.integers(0, 255)), min_size=1, max_size=3))
def test_a_damaged_archive_is_one_line(archive: Path, changes: list[tuple[int, int]]) -> None:
    path = archive.with_name("damaged.npz")
    data = bytearray(archive.read_bytes())
    for place, byte in changes:
        data[place % len(data)] = byte
    path.write_bytes(data)
    try:
        truth_map.read(path).lattice(GridGeometry(0.5, 0.0, 0.0, 4, 4))
    except UsageError as error:
        assert len(error.problems) == 1


@pytest.mark.parametrize(
    ("name", "array"),
    [
        ("origin", [np.inf, 0.0, 0.0]),
        ("origin", [1e300, 0.0, 0.0]),
        ("unknown", np.zeros(3, np.bool_)),
        ("unknown", np.zeros((2, 3), np.int64)),
        ("occupancy", np.zeros((2, 3), np.complex128)),
        ("occupancy", np.zeros((2, 3, 1))),
    ],
)
def test_an_archive_of_other_arrays_is_one_line(folder: Path, name: str, array: NDArray[Any]) -> None:
    with np.load(folder / "map.npz") as arrays:
        np.savez_compressed(folder / "map.npz", **{**arrays, name: np.asarray(array)})
    with pytest.raises(UsageError, match=r"is no map\.npz of ours") as raised:
        truth_map.read(folder / "map.npz")
    assert len(raised.value.problems) == 1


def test_an_archive_that_unpacks_to_more_than_a_map_is_refused(folder: Path) -> None:
    with ZipFile(folder / "map.npz", "a", ZIP_DEFLATED, compresslevel=1) as archive:
        archive.writestr("more.npy", bytes((1 << 28) + 1))
    with pytest.raises(UsageError, match="more than any map"):
        truth_map.read(folder / "map.npz")


def test_cells_of_another_size_are_refused_with_the_mend() -> None:
    truth = TruthMap(MAP.geometry, np.array(WALLS), np.array(FREE))
    with pytest.raises(UsageError, match=r"cells of 0\.5 m, the log's map of 0\.1 m: .*resolution_m"):
        truth.lattice(GridGeometry(0.1, 0.0, 0.0, 10, 10))


OFFSETS = st.floats(-5.0, 5.0)


@given(OFFSETS, OFFSETS, st.integers(1, 20), st.integers(1, 20))
def test_its_cells_are_continued_over_any_area(x: float, y: float, rows: int, cols: int) -> None:
    truth = TruthMap(MAP.geometry, np.array(WALLS), np.array(FREE))
    area = GridGeometry(0.5, x, y, rows, cols)
    lattice = truth.lattice(area)
    assert lattice.x <= area.x + 1e-9
    assert lattice.y <= area.y + 1e-9
    assert lattice.x + lattice.cols * 0.5 >= area.x + area.cols * 0.5 - 1e-9
    assert lattice.y + lattice.rows * 0.5 >= area.y + area.rows * 0.5 - 1e-9
    walls, free = truth.on(lattice)
    for row, col in np.ndindex(2, 3):
        point = MAP.geometry.x_centres[col], MAP.geometry.y_centres[row]
        cell = lattice.cell(*point)
        if lattice.contains(*cell):
            assert (walls[cell], free[cell]) == (WALLS[row][col], FREE[row][col])
    inside = sum(lattice.contains(*lattice.cell(*(at))) for at in _centres())
    assert np.count_nonzero(walls | free) <= inside


def _centres() -> list[tuple[float, float]]:
    return [(float(x), float(y)) for x in MAP.geometry.x_centres for y in MAP.geometry.y_centres]
