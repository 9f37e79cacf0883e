"""Signals of DBC files against cantools, which reads the files for us but decodes no frame."""

from math import isnan
from pathlib import Path
from struct import pack
from typing import Any

from hypothesis import given, settings
from hypothesis.strategies import binary, booleans, composite, floats, integers, sampled_from, text
from pytest import approx, fixture, importorskip, mark, raises
from pytest_mock import MockerFixture

from echogrid.drivers.dbc import Signal, load_signals

cantools = importorskip("cantools", reason="cantools is not installed")

CONTROLLER = """VERSION ""

BO_ 5 Status: 8 Controller
 SG_ Position : 0|32@1+ (1,0) [0|0] "counts" Host
 SG_ Speed : 39|16@0- (0.1,-5) [0|0] "rpm" Host
 SG_ Angle : 48|16@1- (0.1,0) [0|0] "deg" Host

BO_ 2566834709 Extended: 8 Controller
 SG_ Exact : 0|64@1- (1,0) [0|0] "rad" Host

BO_ 7 Chosen: 8 Controller
 SG_ Which M : 0|8@1+ (1,0) [0|0] "" Host
 SG_ First m0 : 8|16@1+ (1,0) [0|0] "" Host
 SG_ Always : 32|16@1+ (1,0) [0|0] "" Host

BO_ 8 Long: 64 Controller
 SG_ Far : 0|16@1+ (1,0) [0|0] "" Host

BO_ 9 Sloppy: 2 Controller
 SG_ Beyond : 0|32@1+ (1,0) [0|0] "" Host
 SG_ Half : 0|12@1+ (1,0) [0|0] "" Host

SIG_VALTYPE_ 2566834709 Exact : 2;
SIG_VALTYPE_ 9 Half : 1;
"""


@fixture
def file(tmp_path: Path) -> str:
    path = tmp_path / "controller.dbc"
    path.write_text(CONTROLLER)
    return str(path)


def signal(file: str, name: str) -> Signal:
    (found,) = load_signals(file, [name])
    return found


def test_signals_are_where_the_file_says(file: str) -> None:
    position, speed = load_signals(file, ["Status.Position", "Status.Speed"])
    data = bytes.fromhex("FB FF FF FF 01 02 00 00")
    assert position.value(data) == 0xFFFF_FFFB
    assert speed.value(data) == 0x0102 * 0.1 - 5
    assert (position.identifier, position.extended, position.length) == (5, False, 8)


def test_a_sign_can_be_given_and_taken(file: str) -> None:
    position = signal(file, "Status.Position")
    data = bytes.fromhex("FB FF FF FF 00 00 00 00")
    assert position.with_sign(True).value(data) == -5
    assert position.with_sign(None).value(data) == position.with_sign(False).value(data) == 0xFFFF_FFFB


def test_a_float_in_an_extended_frame_is_read(file: str) -> None:
    exact = signal(file, "Extended.Exact")
    assert (exact.extended, exact.identifier) == (True, 2566834709 & 0x1FFF_FFFF)
    assert exact.value(bytes.fromhex("000000000000F8BF")) == -1.5


@mark.parametrize(
    ("name", "words"),
    [
        ("Statis.Position", "no message 'Statis' in the DBC file (did you mean 'Status'?)"),
        ("Status.Positron", "no Status signal 'Positron' in the DBC file (did you mean 'Position'?)"),
        (
            "%%%.Position",
            "no message '%%%' in the DBC file (there are: Chosen, Extended, Long, Sloppy, Status)",
        ),
        ("Chosen.First", "Chosen.First is multiplexed: that is not supported"),
        ("Long.Far", "Long.Far does not fit a frame of 8 bytes"),
        ("Sloppy.Beyond", "Sloppy.Beyond does not fit a frame of 2 bytes"),
        ("Sloppy.Half", "Sloppy.Half is a float of 12 bits: expected 16, 32 or 64"),
    ],
)
def test_a_signal_that_can_not_be_is_refused_by_name(file: str, name: str, words: str) -> None:
    with raises(ValueError) as caught:
        load_signals(file, [name])
    assert str(caught.value) == words


def test_a_signal_beside_multiplexed_ones_is_read(file: str) -> None:
    assert signal(file, "Chosen.Always").value(bytes.fromhex("0500000034120000")) == 0x1234


def test_a_missing_file_is_told_with_where_it_is_looked_for() -> None:
    with raises(ValueError, match=r"`file`: no/such.dbc: No such file or directory \(an absolute path, or"):
        load_signals("no/such.dbc", ["A.B"])


@settings(max_examples=30)
@given(content=text() | sampled_from(["", "BO_ 1 A: 8 X\n SG_ S : abc", CONTROLLER[:200]]))
def test_what_is_no_dbc_file_is_told_as_that(tmp_path_factory: Any, content: str) -> None:
    path = tmp_path_factory.mktemp("dbc") / "x.dbc"
    path.write_text(content, encoding="utf-8")
    with raises(ValueError, match=r"not a DBC file|in the DBC file"):
        load_signals(str(path), ["A.Nothing"])


def test_without_cantools_the_mend_is_told(file: str, mocker: MockerFixture) -> None:
    mocker.patch.dict("sys.modules", {"cantools": None})
    with raises(ValueError, match="pip install cantools"):
        load_signals(file, ["Status.Position"])


@composite
def described(draw: Any) -> tuple[str, int]:
    """A DBC file with one signal, and the length of its message."""
    length, little, floating = draw(integers(1, 8)), draw(booleans()), draw(booleans())
    sizes = [size for size in (16, 32, 64) if size <= 8 * length] if floating else []
    bits = draw(sampled_from(sizes)) if sizes else draw(integers(1, 8 * length))
    first = draw(integers(0, 8 * length - bits))
    start = first if little else first // 8 * 8 + 7 - first % 8
    sign = "-" if sizes or draw(booleans()) else "+"
    factor, offset = draw(sampled_from([1, -1, 0.1, 0.00025, 3])), draw(sampled_from([0, -5, 2.5]))
    kind = {32: 1, 64: 2}.get(bits) if sizes else None
    types = f"SIG_VALTYPE_ 5 S : {kind};\n" if kind else ""
    return (
        f'VERSION ""\n\nBO_ 5 M: {length} X\n'
        f' SG_ S : {start}|{bits}@{int(little)}{sign} ({factor},{offset}) [0|0] "" Y\n\n{types}',
        length,
    )


@given(described(), binary(min_size=8, max_size=8))
def test_every_signal_is_decoded_as_by_cantools(
    tmp_path_factory: Any, case: tuple[str, int], data: bytes
) -> None:
    content, length = case
    path = tmp_path_factory.mktemp("dbc") / "x.dbc"
    path.write_text(content)
    message = cantools.database.load_string(content, "dbc").get_message_by_name("M")
    ours = signal(str(path), "M.S")
    unscaled = message.decode(data[:length], scaling=False)["S"]
    assert ours.raw(data) == approx(unscaled, rel=0, abs=0, nan_ok=True)
    assert ours.value(data) == approx(message.decode(data[:length])["S"], rel=1e-15, abs=0, nan_ok=True)


@given(floats(width=16))
def test_half_floats_are_read(number: float) -> None:
    half = Signal(1, False, 2, "little", 0, 16, True, True, 1.0, 0.0)
    value = half.value(pack("<e", number))
    assert value == number or (isnan(value) and isnan(number))
