import errno
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from pytest_mock import MockerFixture

from echogrid.mapping.pose import Pose
from echogrid.runtime import map_files

from .maps import image

NAN = float("nan")
MIXED = image([[0.01, 0.99, NAN], [0.195, 0.1961, 0.5], [0.65, 0.6501, NAN], [0.0, 1.0, 0.2]])
PATH = [(1_500_000_001, Pose(0.25, -0.5, 0.0)), (2_000_000_000, Pose(1.0, 2.0, np.pi))]
GRIDS = st.integers(1, 6).flatmap(
    lambda cols: st.lists(
        st.lists(st.floats(0, 1, width=32) | st.just(NAN), min_size=cols, max_size=cols),
        min_size=1,
        max_size=6,
    )
)
FREE, OCCUPIED, UNKNOWN = 0, 100, -1


def map_server(folder: Path) -> tuple[NDArray[np.int8], float, list[float]]:
    """As nav2's map_server reads it, trinary: occupancy (row 0 south), resolution, origin."""
    told = dict(line.split(": ", 1) for line in (folder / "map.yaml").read_text().splitlines())
    assert (told["mode"], told["negate"]) == ("trinary", "0")
    magic, size, most, pixels = (folder / told["image"]).read_bytes().split(b"\n", 3)
    assert (magic, most) == (b"P5", b"255")
    cols, rows = map(int, size.split())
    shades = np.frombuffer(pixels, np.uint8).reshape(rows, cols) / 255.0
    occupancy = 1.0 - shades
    cells = np.full((rows, cols), UNKNOWN, np.int8)
    cells[occupancy > float(told["occupied_thresh"])] = OCCUPIED
    cells[occupancy < float(told["free_thresh"])] = FREE
    origin = [float(part) for part in told["origin"].strip("[]").split(",")]
    return cells[::-1], float(told["resolution"]), origin


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(GRIDS)
def test_map_server_reads_the_trinary_map_back(tmp_path: Path, occupancy: list[list[float]]) -> None:
    made = image(occupancy)
    map_files.write(tmp_path, made, [])
    expected = np.full(made.occupancy.shape, UNKNOWN, np.int8)
    expected[made.occupancy > 0.65] = OCCUPIED
    expected[made.occupancy < 0.196] = FREE
    expected[made.unknown] = UNKNOWN
    cells, resolution, origin = map_server(tmp_path)
    np.testing.assert_array_equal(cells, expected)
    assert (resolution, origin) == (0.5, [-1.0, 2.0, 0.0])


def test_unknown_would_be_free_to_map_server_s_own_default_but_not_to_ours(tmp_path: Path) -> None:
    map_files.write(tmp_path, image([[NAN]]), [])
    shade = (tmp_path / "map.pgm").read_bytes()[-1]
    assert 0.196 < 1.0 - shade / 255.0 < 0.25


def test_the_arrays_have_their_names_types_and_row_0_in_the_south(tmp_path: Path) -> None:
    map_files.write(tmp_path, MIXED, [])
    with np.load(tmp_path / "map.npz") as arrays:
        assert set(arrays) == {"occupancy", "unknown", "resolution", "origin"}
        assert (arrays["occupancy"].dtype, arrays["unknown"].dtype) == (np.float32, np.bool_)
        assert arrays["occupancy"][0, 1] == np.float32(0.99)
        np.testing.assert_array_equal(arrays["occupancy"], MIXED.occupancy)
        np.testing.assert_array_equal(arrays["unknown"], MIXED.unknown)
        assert arrays["resolution"] == 0.5
        np.testing.assert_array_equal(arrays["origin"], [-1.0, 2.0, 0.0])


def test_the_path_is_written_as_tum(tmp_path: Path) -> None:
    map_files.write(tmp_path, MIXED, PATH)
    assert (tmp_path / "trajectory.tum").read_text() == (
        "1.500000001 0.250000 -0.500000 0 0 0 0.000000000 1.000000000\n"
        "2.000000000 1.000000 2.000000 0 0 0 1.000000000 0.000000000\n"
    )


def test_the_same_map_gives_the_same_bytes(tmp_path: Path) -> None:
    for name in ("one", "other"):
        map_files.write(tmp_path / name, MIXED, PATH)
    for path in (tmp_path / "one").iterdir():
        assert path.read_bytes() == (tmp_path / "other" / path.name).read_bytes()


def test_all_files_are_there_and_nothing_else(tmp_path: Path) -> None:
    map_files.write(tmp_path / "deep" / "er", MIXED, PATH)
    assert {path.name for path in (tmp_path / "deep" / "er").iterdir()} == {
        "map.yaml",
        "map.pgm",
        "map.png",
        "map.npz",
        "trajectory.tum",
    }


@pytest.mark.parametrize("failing", ["write_bytes", "replace"])
def test_when_the_disk_is_full_the_old_file_stays_whole(
    tmp_path: Path, mocker: MockerFixture, failing: str
) -> None:
    path = tmp_path / "report.json"
    map_files.replace(path, b"old")
    mocker.patch(f"pathlib.Path.{failing}", side_effect=OSError(errno.ENOSPC, "No space left on device"))
    with pytest.raises(OSError, match="No space left"):
        map_files.replace(path, b"new")
    mocker.stopall()
    assert [(each.name, each.read_bytes()) for each in tmp_path.iterdir()] == [("report.json", b"old")]


def test_a_new_file_takes_the_place_of_the_old_one(tmp_path: Path) -> None:
    path = tmp_path / "report.json"
    map_files.replace(path, b"a longer old one")
    reader = path.open("rb")
    map_files.replace(path, b"new")
    with reader:
        assert reader.read() == b"a longer old one"
    assert path.read_bytes() == b"new"


@pytest.mark.parametrize(
    ("stamp_ns", "text"),
    [(0, "0.000000000"), (-1, "-0.000000001"), (1_700_000_000_123_456_789, "1700000000.123456789")],
)
def test_a_stamp_is_written_with_all_its_digits(stamp_ns: int, text: str) -> None:
    assert map_files.seconds(stamp_ns) == text
