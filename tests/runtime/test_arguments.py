import argparse

import pytest
from hypothesis import given
from hypothesis import strategies as st

from echogrid.runtime.commands import arguments
from echogrid.runtime.commands.arguments import duration, length


@pytest.mark.parametrize(
    ("text", "seconds"),
    [("60s", 60.0), ("1.5min", 90.0), ("2h", 7200.0), ("500ms", 0.5), ("7", 7.0), (" 1 s ", 1.0)],
)
def test_a_duration_has_a_unit_or_is_in_seconds(text: str, seconds: float) -> None:
    assert duration(text) == pytest.approx(seconds)


@pytest.mark.parametrize(
    "text", ["", "0", "0s", "-1s", "1d", "s", "1.2.3s", "inf", "nan", "1e3s", "9" * 400 + "s"]
)
def test_what_is_no_duration_is_refused_by_name(text: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError, match="is no duration"):
        duration(text)


@pytest.mark.parametrize("text", ["", "0", "-1", "inf", "nan", "x"])
def test_what_is_no_length_is_refused_by_name(text: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError, match="is no length"):
        length(text)


@given(st.text())
def test_any_text_is_a_duration_or_refused(text: str) -> None:
    try:
        assert duration(text) > 0.0
    except argparse.ArgumentTypeError as error:
        assert repr(text) in str(error)


def test_the_robot_s_directory_is_the_user_s_own(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", "/run/user/7")
    assert str(arguments.robot_directory()) == "/run/user/7/echogrid"
    monkeypatch.delenv("XDG_RUNTIME_DIR")
    assert str(arguments.robot_directory()).startswith("/tmp/echogrid-")


@pytest.mark.parametrize("text", ["-1", "x", "1.5", ""])
def test_a_seed_is_a_whole_number_from_0_on(text: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError, match="is no seed"):
        arguments.seed(text)
