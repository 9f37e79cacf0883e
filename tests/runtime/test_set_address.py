from collections.abc import Iterator
from io import StringIO
from pathlib import Path

import pytest

from echogrid.emulation.robot import RangerSpec
from echogrid.runtime.command_line import main

from .served import served


@pytest.fixture
def ring(short_dir: Path) -> Iterator[str]:
    """An I2C bus with two SRF08s, at 0x70 and 0x72."""
    rangers = [
        RangerSpec("front", "srf08", "ring", 0.0, 0.0, 0.0, {"address": 0x70}),
        RangerSpec("rear", "srf08", "ring", 0.0, 0.0, 0.0, {"address": 0x72}),
    ]
    with served(short_dir, {"ring": "i2c"}, rangers, 1.5):
        yield f"unix:{short_dir / 'ring.sock'}"


def test_a_ranger_moves_to_another_address_and_that_is_proved(
    ring: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["set-address", "srf08", ring, "0x70", "0x75", "--yes"]) == 0
    assert capsys.readouterr().out.splitlines() == [
        f"{ring}: srf08 at 0x70 says 1.500 m",
        "done: srf08 at 0x75 says 1.500 m",
    ]
    main(["scan", ring])
    assert capsys.readouterr().out.splitlines()[1:] == ["  0x72  srf08", "  0x75  srf08"]


def test_without_a_yes_nothing_is_changed(
    ring: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.stdin", StringIO())
    assert main(["set-address", "srf08", ring, "0x70", "0x75"]) == 1
    told = capsys.readouterr()
    assert "Is it the only one at 0x70?" in told.err
    assert "nothing was changed" in told.err
    main(["scan", ring])
    assert "  0x70  srf08" in capsys.readouterr().out


def test_an_address_that_is_taken_is_refused(ring: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["set-address", "srf08", ring, "0x70", "0x72", "--yes"]) == 1
    assert "there is a device at 0x72 already" in capsys.readouterr().err


def test_nobody_at_the_present_address_is_told(ring: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["set-address", "srf08", ring, "0x71", "0x75", "--yes"]) == 1
    assert "no srf08 at 0x71: no answer" in capsys.readouterr().err


def test_another_make_is_not_moved_and_its_address_is_taken(
    short_dir: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rangers = [
        RangerSpec("two", "srf02", "ring", 0.0, 0.0, 0.0, {"address": 0x70}),
        RangerSpec("eight", "srf08", "ring", 0.0, 0.0, 0.0, {"address": 0x72}),
        RangerSpec("urm", "urm09", "ring", 0.0, 0.0, 0.0),
    ]
    with served(short_dir, {"ring": "i2c"}, rangers, 1.5):
        port = f"unix:{short_dir / 'ring.sock'}"
        assert main(["set-address", "srf08", port, "0x70", "0x75", "--yes"]) == 1
        assert "no srf08 at 0x70: " in capsys.readouterr().err
        assert main(["set-address", "urm09", port, "0x11", "0x72", "--yes"]) == 1
        assert "there is a device at 0x72 already" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["a02yyuw", "port", "1", "2"], "'a02yyuw' can't be given an address by echogrid"),
        (["srf08", "port", "0x70", "0x10"], "address is 0x10: expected 0x70 to 0x7f"),
        (["srf08", "port", "0x70", "here"], "'here' is no address"),
        (["urm12", "port", "300", "5"], "address is 300: expected 1 to 247"),
    ],
)
def test_misuse_is_2_with_words(arguments: list[str], told: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["set-address", *arguments]) == 2
    assert told in capsys.readouterr().err
