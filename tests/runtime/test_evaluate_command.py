import argparse

import pytest

from echogrid.emulation.worlds import WORLDS
from echogrid.runtime import command_line, map_table
from echogrid.runtime.commands.evaluate import worlds


def test_worlds_are_named_with_commas_between() -> None:
    assert worlds("office, museum") == ["office", "museum"]


@pytest.mark.parametrize("text", ["", "offce", "office,", "office museum"])
def test_a_world_that_is_not_is_refused_with_the_names_of_those_that_are(text: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError, match=r"no world is called .*office"):
        worlds(text)


@pytest.mark.parametrize(
    ("told", "due"),
    [
        ((), (list(WORLDS), [1, 2, 3, 4, 5], 2)),
        (("--seeds", "2", "--worlds", "home", "--seed", "7", "--processes", "3"), (["home"], [7, 8], 3)),
    ],
)
def test_maps_are_judged_as_told(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], told: tuple[str, ...], due: object
) -> None:
    asked = []

    def tables(worlds: list[str], seeds: range, contenders: object, processes: int) -> list[str]:
        asked.append((worlds, list(seeds), processes))
        return ["| a table |"]

    monkeypatch.setattr(map_table, "tables", tables)
    assert command_line.main(["evaluate", "--maps", *told]) == 0
    assert asked == [due]
    assert capsys.readouterr().out == "| a table |\n"


def test_worlds_without_maps_are_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert command_line.main(["evaluate", "--worlds", "foyer"]) == 2
    assert "--worlds is for --maps" in capsys.readouterr().err
