from hypothesis import given
from hypothesis import strategies as st

from echogrid.runtime.toml_lines import key_lines

TEXT = """\
# A comment with key = 1
[robot]  # the robot
name = "r"

[[sensor]]
x_m = 1
[[sensor]]
x_m = 2
groups = [
  ["a", "b"],
]
[ map ]
  size = 3
"""


def test_tables_and_keys_are_found_where_they_stand() -> None:
    assert key_lines(TEXT) == {
        ("robot",): 2,
        ("robot", "name"): 3,
        ("sensor", 0): 5,
        ("sensor", 0, "x_m"): 6,
        ("sensor", 1): 7,
        ("sensor", 1, "x_m"): 8,
        ("sensor", 1, "groups"): 9,
        ("map",): 12,
        ("map", "size"): 13,
    }


def test_keys_before_the_first_table_are_found() -> None:
    assert key_lines("\nname = 1\n") == {("name",): 2}


@given(st.lists(st.sampled_from(["[[sensor]]", "x = 1", "", "[robot]", '["quoted"]', "y=2 # z=3"])))
def test_every_line_number_is_that_of_a_line_with_the_name(lines: list[str]) -> None:
    for place, number in key_lines("\n".join(lines)).items():
        name = next(part for part in reversed(place) if isinstance(part, str))
        assert name in lines[number - 1]
