from pathlib import Path
from random import Random

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from echogrid.runtime import offline, recording
from echogrid.runtime.errors import UsageError
from echogrid.runtime.offline import OfflineMap

from . import recordings


def built(folder: Path) -> tuple[OfflineMap, recording.Recording]:
    told = recording.read_simple(folder)
    made = offline.build(told)
    assert made.ledger.balances(0)
    return made, told


def same(one: OfflineMap, other: OfflineMap) -> bool:
    return (
        one.image.geometry == other.image.geometry
        and one.image.occupancy.tobytes() == other.image.occupancy.tobytes()
        and one.image.unknown.tobytes() == other.image.unknown.tobytes()
    )


def shuffled(rows: list[str], within_s: float, random: Random) -> list[str]:
    """Out of order by at most so much."""
    keys = {row: float(row.split(",")[0]) + random.uniform(0, within_s) for row in rows}
    return sorted(rows, key=keys.__getitem__)


@settings(max_examples=15, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.randoms(use_true_random=False), st.sampled_from([1.0, 1e6]))
def test_the_order_of_the_rows_does_not_change_the_map(
    tmp_path: Path, random: Random, within_s: float
) -> None:
    rows = recordings.range_rows()
    straight, _ = built(recordings.write(tmp_path / "straight", ranges=rows))
    other, _ = built(recordings.write(tmp_path / "other", ranges=shuffled(rows, within_s, random)))
    assert straight.ledger.fused > 100
    assert same(straight, other)


@pytest.mark.parametrize("stamp", ["3999999999", "9.9", "-5"], ids=["far", "within the span", "before"])
def test_one_row_with_a_wrong_stamp_does_not_spoil_the_rest(tmp_path: Path, stamp: str) -> None:
    rows = recordings.range_rows()
    right, _ = built(recordings.write(tmp_path / "right", ranges=rows))
    wrong, _ = built(
        recordings.write(tmp_path / "wrong", ranges=[*rows[:50], f"{stamp},front,nan", *rows[50:]])
    )
    assert same(right, wrong)
    assert wrong.ledger.produced == right.ledger.produced + 1


def test_one_pose_with_a_wrong_stamp_does_not_spoil_the_rest(tmp_path: Path) -> None:
    rows = recordings.pose_rows()
    right, _ = built(recordings.write(tmp_path / "right"))
    wrong, told = built(
        recordings.write(tmp_path / "wrong", poses=[*rows[:50], "3999999999,0,0,0", *rows[50:]])
    )
    assert same(right, wrong)
    assert told.faults.counts == {"pose not monotonic": 1}


def test_a_range_without_a_pose_around_it_is_dropped_and_told(tmp_path: Path) -> None:
    folder = recordings.write(tmp_path, ranges=["-1,front,1", "5,front,1", "11,front,1", "12,left,1"])
    made, told = built(folder)
    assert made.ledger.dropped == {"outside the pose span": 3}
    assert told.faults.lines() == [
        f"{folder}/ranges.csv:2: range outside the pose span: 3 rows skipped from here on"
    ]


def test_a_range_in_a_gap_of_the_poses_is_dropped(tmp_path: Path) -> None:
    rows = recordings.pose_rows()
    made, _ = built(recordings.write(tmp_path, poses=rows[:30] + rows[50:], ranges=["4,front,1"]))
    assert made.ledger.dropped == {"pose gap": 1}


def test_stamps_of_any_epoch_are_fused(tmp_path: Path) -> None:
    late = [f"{3_999_999_000 + step * 0.1:.1f},{step * 0.01:.2f},0,0" for step in range(50)]
    made, _ = built(recordings.write(tmp_path, poses=late, ranges=["3999999002.05,front,1"]))
    assert made.ledger.fused == 1


def test_without_a_size_the_grid_is_fitted_to_all_that_can_be_seen(tmp_path: Path) -> None:
    made, told = built(recordings.write(tmp_path))
    geometry = made.image.geometry
    for _, pose in told.poses:
        for dx in (-3.0, 3.0):
            assert geometry.contains(*geometry.cell(pose.x + dx, pose.y + dx))
    assert "outside the map" not in made.ledger.dropped


def test_with_a_size_the_grid_is_around_the_first_pose(tmp_path: Path) -> None:
    robot = recordings.ROBOT.replace("[map]\n", "[map]\nwidth_m = 4.0\nheight_m = 2.0\n")
    geometry = built(recordings.write(tmp_path, robot=robot))[0].image.geometry
    assert (geometry.cols, geometry.rows, geometry.x, geometry.y) == (40, 20, -2.0, -1.0)


@pytest.mark.parametrize("x", ["1e6", "1e9", "-1e9"])
def test_a_monstrous_extent_is_refused_in_words(tmp_path: Path, x: str) -> None:
    folder = recordings.write(tmp_path, poses=["0,0,0,0", f"1,{x},{x},0"])
    with pytest.raises(
        UsageError, match=r"a map of .* has .* cells, more than 4e\+07: give \[map\] `width_m`"
    ):
        built(folder)


def test_a_recording_without_a_usable_pose_is_refused_in_words(tmp_path: Path) -> None:
    with pytest.raises(UsageError) as caught:
        built(recordings.write(tmp_path, poses=["x,0,0,0"]))
    assert caught.value.problems == (
        "no usable pose: nothing can be placed",
        f"{tmp_path}/poses.csv:2: unparsable: 1 row skipped from here on",
    )


def test_a_recording_without_ranges_gives_an_empty_map(tmp_path: Path) -> None:
    made, _ = built(recordings.write(tmp_path, ranges=[]))
    assert made.image.unknown.all()
    assert made.ledger.produced == 0


def test_the_report_holds_the_books(tmp_path: Path) -> None:
    made, told = built(recordings.write(tmp_path, ranges=[*recordings.range_rows(), "x,front,1"]))
    report = made.report(told.faults)
    assert report["readings"] == 200 == report["fused"] + sum(report["dropped"].values())
    assert report["readings"] == sum(report["outcomes"].values())
    assert (report["waiting"], report["balances"], report["rows_skipped"]) == (0, True, {"unparsable": 1})
