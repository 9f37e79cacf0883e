import tomllib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from echogrid.runtime.emulated import DEFAULT_ROBOT
from echogrid.runtime.toml_edit import with_values

TEXT = """\
# A robot.
[robot]
name = "r" # its name
wheel_radius_m=0.06   # by calliper
track_m = 0.32

[[sensor]]
track_m = 9 # not this one
"""
numbers = st.floats(1e-3, 100.0)


@given(numbers, numbers)
def test_the_built_in_robot_says_the_new_numbers_and_all_else_as_before(radius: float, ratio: float) -> None:
    text = DEFAULT_ROBOT.read_text()
    edited = with_values(text, "robot", {"wheel_radius_m": radius, "wheel_ratio": ratio})
    table, before = tomllib.loads(edited), tomllib.loads(text)
    assert table["robot"].pop("wheel_radius_m") == pytest.approx(radius, rel=1e-6)
    assert table["robot"].pop("wheel_ratio") == pytest.approx(ratio, rel=1e-6)
    del before["robot"]["wheel_radius_m"]
    assert table == before
    assert len(edited.splitlines()) == len(text.splitlines()) + 1


def test_comments_and_spaces_stay_and_new_keys_follow_the_old_ones() -> None:
    edited = with_values(TEXT, "robot", {"wheel_radius_m": 0.0612345678, "wheel_ratio": 1.003})
    assert edited == TEXT.replace(
        "wheel_radius_m=0.06   # by calliper\n",
        "wheel_radius_m=0.06123457   # by calliper\nwheel_ratio = 1.003\n",
    )


def test_the_same_key_of_another_table_is_left_alone() -> None:
    assert with_values(TEXT, "robot", {"track_m": 0.3}) == TEXT.replace("track_m = 0.32", "track_m = 0.3")


def test_without_any_of_the_keys_they_follow_the_header() -> None:
    assert with_values('[robot]\nname = "r"', "robot", {"x": 2.0}) == '[robot]\nx = 2.0\nname = "r"'


def test_a_last_line_without_an_end_gets_one() -> None:
    assert with_values("[robot]\ntrack_m = 1", "robot", {"track_m": 2.0, "x": 3.0}) == (
        "[robot]\ntrack_m = 2.0\nx = 3.0\n"
    )


def test_the_ends_of_lines_stay_what_they_are() -> None:
    text = TEXT.replace("\n", "\r\n")
    edited = with_values(text, "robot", {"track_m": 0.5, "wheel_ratio": 1.5})
    assert edited == text.replace("track_m = 0.32\r\n", "track_m = 0.5\r\nwheel_ratio = 1.5\r\n")


def test_a_key_of_one_of_several_tables_is_set_in_that_one() -> None:
    text = TEXT + "\n[[sensor]]\nx_m = 1.0\n\n[[sensor]]\n"
    assert with_values(text, "sensor", {"x_m": 2.0}, 1) == text.replace("x_m = 1.0", "x_m = 2.0")
    assert with_values(text, "sensor", {"x_m": 3.0}, 2) == text + "x_m = 3.0\n"


def test_nothing_to_change_changes_nothing() -> None:
    assert with_values(TEXT, "robot", {}) == TEXT


@pytest.mark.parametrize(
    "text",
    [
        "robot = { track_m = 0.3 }",
        "robot.track_m = 0.3",
        "[other]\nx = 1",
        "robot = 3",
        '[robot]\nname = """\ntrack_m = 1\n"""\ntrack_m = 0.3',
    ],
)
def test_what_can_not_be_edited_line_by_line_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="one key a line"):
        with_values(text, "robot", {"track_m": 0.4})
