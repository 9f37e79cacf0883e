from dataclasses import dataclass
from typing import Any, Literal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from echogrid.mapping.sonar_model import NoEcho
from echogrid.runtime.toml_values import nearest, structured


@dataclass(frozen=True)
class Part:
    size: float
    count: int = 1

    def __post_init__(self) -> None:
        if self.size <= 0:
            raise ValueError("`size` must be above 0")


@dataclass(frozen=True)
class Whole:
    part: Part
    parts: tuple[Part, ...] = ()
    groups: tuple[tuple[str, ...], ...] = ()
    label: str = "x"
    on: bool = False
    kind: Literal["serial", "can"] = "can"
    no_echo: NoEcho = NoEcho.WEAK


GOOD: dict[str, Any] = {"part": {"size": 1}}
SCALARS = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5)
VALUES = st.recursive(
    SCALARS,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=6,
)


def problems(**changes: object) -> list[tuple[object, str]]:
    value, found = structured(GOOD | changes, Whole)
    assert (value is None) == bool(found)
    return list(found)


def test_a_good_table_becomes_its_dataclass() -> None:
    table = {
        "part": {"size": 2},
        "parts": [{"size": 0.5, "count": 3}],
        "groups": [["a"], []],
        "no_echo": "clear",
    }
    value, found = structured(table, Whole)
    assert value == Whole(Part(2.0), (Part(0.5, 3),), (("a",), ()), no_echo=NoEcho.CLEAR)
    assert found == []


@pytest.mark.parametrize(
    ("changes", "place", "reason"),
    [
        ({"part": {"size": True}}, ("part", "size"), "expected a number, not True"),
        ({"part": {"size": float("nan")}}, ("part", "size"), "expected a number, not nan"),
        ({"part": {"size": float("inf")}}, ("part", "size"), "expected a number, not inf"),
        ({"part": {"size": "1"}}, ("part", "size"), "expected a number, not '1'"),
        ({"part": {"size": 10**400}}, ("part", "size"), "expected a number, not 1000"),
        ({"part": {"size": 1, "count": 1.0}}, ("part", "count"), "expected a whole number, not 1.0"),
        ({"part": {"size": 1, "count": True}}, ("part", "count"), "expected a whole number, not True"),
        ({"part": {"size": -1}}, ("part",), "`size` must be above 0"),
        ({"part": {}}, ("part", "size"), "missing key `size`"),
        ({"part": 5}, ("part",), "expected a table, not 5"),
        ({"part": {"size": 1, "cuont": 2}}, ("part", "cuont"), "unknown key `cuont` (did you mean `count`?)"),
        ({"parts": {"size": 1}}, ("parts",), "expected a list, not {'size': 1}"),
        ({"parts": [{"size": 1}, {}]}, ("parts", 1, "size"), "missing key `size`"),
        ({"groups": "ab"}, ("groups",), "expected a list, not 'ab'"),
        ({"groups": ["ab"]}, ("groups", 0), "expected a list, not 'ab'"),
        ({"groups": [["a", 1]]}, ("groups", 0, 1), "expected a text, not 1"),
        ({"label": ""}, ("label",), "expected a text, not ''"),
        ({"on": 1}, ("on",), "expected true or false, not 1"),
        ({"kind": "cann"}, ("kind",), "expected one of serial, can, not 'cann' (did you mean `can`?)"),
        ({"no_echo": []}, ("no_echo",), "expected one of ignore, weak, clear, not []"),
    ],
)
def test_a_wrong_value_is_told_with_its_place(changes: dict[str, object], place: object, reason: str) -> None:
    ((found_place, found_reason),) = problems(**changes)
    assert found_place == place
    assert found_reason.startswith(reason)


def test_everything_wrong_is_told_at_once() -> None:
    found = problems(part={"a": 1, "b": 2}, parts=[{}, 3], label=4)
    assert {place for place, _ in found} == {
        ("part", "a"),
        ("part", "b"),
        ("part", "size"),
        ("parts", 0, "size"),
        ("parts", 1),
        ("label",),
    }


@given(VALUES)
def test_whatever_it_is_given_it_answers_with_a_value_or_with_problems(value: object) -> None:
    made, found = structured(value, Whole)
    assert isinstance(made, Whole) != bool(found)


@given(st.fixed_dictionaries({}, optional=dict.fromkeys(Whole.__dataclass_fields__, VALUES)))
def test_whatever_its_keys_hold_it_answers_with_a_value_or_with_problems(table: dict[str, object]) -> None:
    made, found = structured(table, Whole)
    assert isinstance(made, Whole) != bool(found)


@pytest.mark.parametrize(
    ("known", "told"),
    [
        ((), "(there is none)"),
        (("a", "b"), "(there are: a, b)"),
        (("fronts", "a"), "(did you mean `fronts`?)"),
    ],
)
def test_an_unknown_name_is_told_with_the_nearest_or_with_all_there_are(
    known: tuple[str, ...], told: str
) -> None:
    assert nearest("front", known) == f" {told}"
