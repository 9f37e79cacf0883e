from decimal import Decimal
from math import inf, isnan, nan, pi
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from echogrid.drivers.readings import Outcome
from echogrid.mapping.kinematics import Differential
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger
from echogrid.runtime import simple_log
from echogrid.runtime.map_files import seconds
from echogrid.runtime.simple_log import RowFaultError, RowFaults

from . import recordings
from .fakes import echo, told

RANGERS = {"front": Ranger("front", Pose(), 0.2, 0.05, 3.0)}
FARTHEST_NS = 4_000_000_000 * 1_000_000_000


@given(st.integers(-FARTHEST_NS, FARTHEST_NS))
def test_a_stamp_keeps_all_its_nanoseconds(stamp_ns: int) -> None:
    assert simple_log.stamp(seconds(stamp_ns)) == stamp_ns


@given(st.decimals(allow_nan=False, allow_infinity=False, min_value=-4e9, max_value=4e9))
def test_a_stamp_is_within_half_a_nanosecond_of_what_is_written(value: Decimal) -> None:
    assert abs(simple_log.stamp(str(value)) - value * 1_000_000_000) <= Decimal("0.5") + abs(value) * Decimal(
        "1e-18"
    )


@pytest.mark.parametrize(
    ("text", "stamp_ns"), [("1e-3", 1_000_000), (".5", 500_000_000), ("1e-999999999", 0)]
)
def test_a_stamp_may_have_an_exponent(text: str, stamp_ns: int) -> None:
    assert simple_log.stamp(text) == stamp_ns


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("", "unparsable"),
        ("soon", "unparsable"),
        ("1.0.0", "unparsable"),
        ("0x10", "unparsable"),
        ("nan", "non-finite stamp"),
        ("sNaN", "non-finite stamp"),
        ("-inf", "non-finite stamp"),
        ("1e999999999", "stamp out of range"),
        ("-1e999999999", "stamp out of range"),
        ("1e12", "stamp out of range"),
        ("1e99999999999999999999999", "unparsable"),
    ],
)
def test_a_stamp_that_is_none_is_a_fault(text: str, fault: str) -> None:
    with pytest.raises(RowFaultError, match=f"^{fault}$"):
        simple_log.stamp(text)


@given(st.text())
def test_any_text_is_a_stamp_or_a_fault(text: str) -> None:
    try:
        assert abs(simple_log.stamp(text)) <= FARTHEST_NS
    except RowFaultError as fault:
        assert str(fault)


@pytest.mark.parametrize(
    ("text", "outcome", "distance"),
    [
        ("1.25", Outcome.ECHO, 1.25),
        ("0.05", Outcome.ECHO, 0.05),
        ("0.0499", Outcome.TOO_CLOSE, nan),
        ("0", Outcome.TOO_CLOSE, nan),
        ("3.0", Outcome.NO_ECHO, nan),
        ("inf", Outcome.NO_ECHO, nan),
        ("+Infinity", Outcome.NO_ECHO, nan),
        ("-inf", Outcome.TOO_CLOSE, nan),
        ("NaN", Outcome.INVALID, nan),
    ],
)
def test_a_range_is_one_of_four_facts(text: str, outcome: Outcome, distance: float) -> None:
    reading = simple_log.range_reading(("1.5", "front", text), RANGERS)
    assert (reading.stamp_ns, reading.outcome) == (1_500_000_000, outcome)
    assert reading.distance == distance or (isnan(distance) and isnan(reading.distance))


@pytest.mark.parametrize(
    ("cells", "fault"),
    [
        (("1", "front", "-0.1"), "negative range"),
        (("1", "front", "1e999999999"), "unparsable"),
        (("1", "front", "-1e999"), "unparsable"),
        (("1", "front", "x"), "unparsable"),
        (("1", "front", ""), "unparsable"),
        (("1", "rear", "1"), "unknown sensor"),
        (("nan", "front", "1"), "non-finite stamp"),
    ],
)
def test_a_range_that_is_none_is_a_fault(cells: tuple[str, ...], fault: str) -> None:
    with pytest.raises(RowFaultError, match=f"^{fault}$"):
        simple_log.range_reading(cells, RANGERS)


@given(st.tuples(st.text() | st.just("1"), st.text() | st.just("front"), st.text()))
def test_any_row_is_a_range_or_a_fault(cells: tuple[str, str, str]) -> None:
    try:
        reading = simple_log.range_reading(cells, RANGERS)
    except RowFaultError as fault:
        assert str(fault)
        return
    assert isnan(reading.distance) != (reading.outcome is Outcome.ECHO)


@given(st.floats(0.05, 3.0, exclude_max=True))
def test_a_distance_keeps_all_its_digits(distance: float) -> None:
    text = simple_log.range_text(echo(0, distance))
    assert simple_log.range_reading(("0", "front", text), RANGERS).distance == distance


@pytest.mark.parametrize("outcome", [Outcome.NO_ECHO, Outcome.TOO_CLOSE, Outcome.INVALID])
def test_an_outcome_without_a_distance_comes_back(outcome: Outcome) -> None:
    text = simple_log.range_text(told(0, outcome))
    assert simple_log.range_reading(("0", "front", text), RANGERS).outcome is outcome


def test_poses_and_wheel_angles_are_read() -> None:
    assert simple_log.pose(("1", "2", "-3", f"{pi!r}")) == (1_000_000_000, Pose(2.0, -3.0, pi))
    angles = simple_log.wheel_angles(("1", "2", "-3"))
    assert (angles.stamp_ns, *angles.both, angles.restarted) == (1_000_000_000, 2.0, -3.0, False)


@pytest.mark.parametrize(("cell", "restarted"), [("0", False), ("1", True)])
def test_a_row_of_wheels_may_tell_of_a_restart(cell: str, restarted: bool) -> None:
    assert simple_log.wheel_angles(("1", "2", "3", cell)).restarted is restarted


@pytest.mark.parametrize("cell", ["", "2", "yes", "1.0"])
def test_a_restart_that_is_neither_told_nor_denied_is_a_fault(cell: str) -> None:
    with pytest.raises(RowFaultError, match=r"^unparsable$"):
        simple_log.wheel_angles(("1", "2", "3", cell))


@pytest.mark.parametrize(
    ("cell", "fault"),
    [
        ("x", "unparsable"),
        ("nan", "non-finite value"),
        ("inf", "non-finite value"),
        ("1e308", "value out of range"),
    ],
)
def test_a_pose_or_angle_that_is_none_is_a_fault(cell: str, fault: str) -> None:
    for read, cells in (
        (simple_log.pose, ("1", "0", "0", cell)),
        (simple_log.wheel_angles, ("1", "0", cell)),
    ):
        with pytest.raises(RowFaultError, match=f"^{fault}$"):
            read(cells)  # type: ignore[operator]


def rows(tmp_path: Path, data: bytes) -> tuple[list[tuple[str, ...]], RowFaults]:
    folder = recordings.write(tmp_path, ranges=data)
    faults = RowFaults()
    assert simple_log.missing(folder, Differential.wheels) == []
    return [row.cells for row in simple_log.rows(folder, simple_log.RANGES, faults)], faults


@pytest.mark.parametrize(
    "data",
    [
        b"stamp_s,sensor,range_m\n1,front,2\n",
        b"\xef\xbb\xbfstamp_s,sensor,range_m\r\n1,front,2\r\n",
        b'"stamp_s","sensor","range_m"\n"1","front","2"\n',
        b" stamp_s , sensor , range_m \n 1 , front , 2 ",
        b"note,range_m,stamp_s,sensor,more\nx,2,1,front,y\n",
        b"stamp_s,sensor,range_m\n\n1,front,2,and,more\n   \n",
        b"stamp_s,sensor,range_m\r1,front,2\r",
    ],
    ids=["plain", "BOM and CRLF", "quotes", "blanks", "other columns", "empty lines", "CR"],
)
def test_a_table_is_read_however_its_lines_and_cells_are_written(tmp_path: Path, data: bytes) -> None:
    cells, faults = rows(tmp_path, data)
    assert cells == [("1", "front", "2")]
    assert faults.counts == {}


def test_a_stray_quote_spoils_its_own_row_only(tmp_path: Path) -> None:
    cells, faults = rows(tmp_path, b'stamp_s,sensor,range_m\n1,"front,2\n2,front,2\n3,front,2\n')
    assert cells == [("2", "front", "2"), ("3", "front", "2")]
    assert faults.lines() == [f"{tmp_path}/ranges.csv:2: unparsable: 1 row skipped from here on"]


def test_short_rows_and_binary_junk_are_counted_with_the_first_one_s_line(tmp_path: Path) -> None:
    junk = bytes(range(256)).replace(b"\n", b"").replace(b"\r", b"")
    data = b"stamp_s,sensor,range_m\n1,front,2\n1,front\n" + junk + b"\n" + b"x" * 200_000 + b"\n2,front,2\n"
    cells, faults = rows(tmp_path, data)
    assert cells[0] == ("1", "front", "2")
    assert cells[-1] == ("2", "front", "2")
    assert faults.lines()[0].startswith(f"{tmp_path}/ranges.csv:3: unparsable: ")


def test_what_a_folder_lacks_is_told_at_once(tmp_path: Path) -> None:
    assert simple_log.missing(tmp_path, Differential.wheels) == [
        f"{tmp_path}/ranges.csv: no such file",
        f"{tmp_path}: neither poses.csv nor wheels.csv: one of them says where the robot was",
    ]
    (tmp_path / "ranges.csv").write_text("stamp_s,sensr\n")
    (tmp_path / "wheels.csv").write_text("")
    assert simple_log.missing(tmp_path, Differential.wheels) == [
        f"{tmp_path}/ranges.csv:1: the header lacks sensor, range_m: it must be stamp_s,sensor,range_m",
        f"{tmp_path}/wheels.csv:1: the header lacks stamp_s, left_rad, right_rad: "
        "it must be stamp_s,left_rad,right_rad",
    ]


def test_no_echo_and_too_close_are_written_as_rep_117_has_them() -> None:
    texts = [simple_log.range_text(told(0, outcome)) for outcome in (Outcome.NO_ECHO, Outcome.TOO_CLOSE)]
    assert [float(text) for text in texts] == [inf, -inf]
