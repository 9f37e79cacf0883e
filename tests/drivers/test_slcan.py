"""The reader of slcan: pure lines, held against the emulated adapter's, which was written apart."""

from collections import Counter
from itertools import pairwise

from hypothesis import example, given
from hypothesis import strategies as st
from pytest import mark, raises

from echogrid.drivers.bus import CanFrame
from echogrid.drivers.transports.can import CanPort
from echogrid.drivers.transports.slcan import BIT_RATES, LineReader, frame_of, line_of, opening
from echogrid.emulation.wires import slcan as emulated

STAMP_NS = 7
IDENTIFIERS = st.one_of(
    st.tuples(st.integers(0, 0x7FF), st.just(False)), st.tuples(st.integers(0, 0x1FFF_FFFF), st.just(True))
)
FRAMES = st.builds(
    lambda identifier, data, remote: CanFrame(identifier[0], b"" if remote else data, identifier[1], remote),
    IDENTIFIERS,
    st.binary(max_size=8),
    st.booleans(),
)
NEARLY_LINES = st.text("tTrRzZVSO0123456789abcDEF \r\a\n_+x", max_size=60).map(str.encode)
NOISE = st.lists(st.one_of(FRAMES.map(emulated.encode), NEARLY_LINES, st.binary(max_size=40))).map(b"".join)


def heard(*chunks: bytes) -> tuple[list[CanFrame], Counter[str]]:
    counts: Counter[str] = Counter()
    reader = LineReader(counts)
    return [frame for chunk in chunks for frame in reader.frames(chunk, STAMP_NS)], counts


@mark.parametrize(
    ("line", "frame"),
    [
        (b"t06980000C03F000010C0", CanFrame(0x069, bytes.fromhex("0000C03F000010C0"))),
        (b"T0000090980000138800640032", CanFrame(0x909, bytes.fromhex("0000138800640032"), extended=True)),
        (b"t7FF0", CanFrame(0x7FF, b"")),
        (b"t0012aabb", CanFrame(0x001, b"\xaa\xbb")),
        (b"r0698", CanFrame(0x069, b"", remote=True)),
        (b"R1FFFFFFF0", CanFrame(0x1FFF_FFFF, b"", extended=True, remote=True)),
    ],
)
def test_a_line_says_a_frame(line: bytes, frame: CanFrame) -> None:
    assert frame_of(line) == frame


@mark.parametrize(
    "line",
    [
        b"",
        b"t",
        b"t8000",
        b"T200000000",
        b"t0012AA",
        b"t0012AABBC",
        b"t0012AABBCCDD",
        b"t0019010203040506070809",
        b"t 010",
        b"t0x10",
        b"t+010",
        b"t0_10",
        b"t0011 A",
        b"r06980",
        b"r0699",
        b"x0012AABB",
        b"tt0012AABB",
    ],
)
def test_anything_else_says_none(line: bytes) -> None:
    assert frame_of(line) is None


@given(FRAMES)
def test_the_emulated_adapter_reads_what_is_sent(frame: CanFrame) -> None:
    assert emulated.decode(line_of(frame).decode().removesuffix("\r")) == frame


@given(FRAMES)
def test_what_the_emulated_adapter_says_is_read(frame: CanFrame) -> None:
    assert frame_of(emulated.encode(frame).removesuffix(b"\r")) == frame


@given(st.one_of(NEARLY_LINES, st.binary(max_size=40)))
def test_both_hold_the_same_lines_for_frames(line: bytes) -> None:
    assert frame_of(line) == emulated.decode(line.decode("latin-1"))


@given(NOISE, st.data())
@example(b"t0012AABB\r" * 2, None)
def test_any_split_of_the_bytes_gives_the_same_frames(stream: bytes, data: st.DataObject | None) -> None:
    whole = heard(stream)
    cuts = sorted(data.draw(st.lists(st.integers(0, len(stream))))) if data else range(len(stream))
    edges = [0, *cuts, len(stream)]
    assert heard(*(stream[start:end] for start, end in pairwise(edges))) == whole
    assert heard(*(stream[at : at + 1] for at in range(len(stream)))) == whole


@given(st.lists(st.binary(max_size=200)))
def test_random_bytes_never_raise_and_give_no_impossible_frame(chunks: list[bytes]) -> None:
    for frame in heard(*chunks)[0]:
        assert 0 <= frame.identifier <= (0x1FFF_FFFF if frame.extended else 0x7FF)
        assert len(frame.data) <= 8


@given(NOISE, FRAMES)
def test_after_any_noise_the_next_line_is_read(noise: bytes, frame: CanFrame) -> None:
    frames, _ = heard(noise + b"\r" + emulated.encode(frame))
    assert (frames[-1].identifier, frames[-1].data) == (frame.identifier, frame.data)


def test_frames_bear_the_time_when_they_were_read() -> None:
    assert heard(b"t0010\r")[0][0].stamp_ns == STAMP_NS


def test_each_bad_line_and_each_refusal_is_counted_once() -> None:
    frames, counts = heard(b"\r\ahello\rt0012AA\rt0010\r" + b"t" * 100_000, b"t" * 100_000 + b"\rt00\a")
    assert len(frames) == 1
    assert counts == {"malformed lines": 4, "refused lines": 1}


def test_answers_are_no_noise() -> None:
    assert heard(b"\rz\rZ\rV1013\rNA123\rF00\r") == ([], Counter())


def test_the_bit_rates_are_the_adapter_s() -> None:
    assert [rate for rate, _ in sorted(BIT_RATES.items(), key=lambda item: item[1])] == list(
        emulated.BIT_RATES
    )


@mark.parametrize("bit_rate", BIT_RATES)
def test_the_emulated_adapter_is_opened_and_hears(bit_rate: int) -> None:
    adapter = emulated.SlcanAdapter(bit_rate)
    assert b"\a" not in adapter.receive(opening(bit_rate))[1]
    assert adapter.line(CanFrame(0x001, b"")) == b"t0010\r"


def test_an_adapter_left_open_by_another_program_is_opened_at_our_bit_rate() -> None:
    adapter = emulated.SlcanAdapter(250_000)
    adapter.receive(b"C\rS8\rO\r")
    adapter.receive(opening(250_000))
    assert adapter.line(CanFrame(0x001, b"")) == b"t0010\r"


def test_a_bit_rate_that_slcan_lacks_is_refused_with_those_that_it_has() -> None:
    with raises(ValueError, match=r"bitrate is 400000: slcan has 10000, 20000, .*, 1000000"):
        opening(400_000)


@mark.parametrize("more", [{"sleep_after_open": 0}, {"tty_baudrate": "fast"}, {"tty_baudrate": 1}])
def test_an_option_that_slcan_lacks_is_refused_by_name(more: dict[str, object]) -> None:
    with raises(ValueError, match="expected"):
        CanPort("/dev/ttyACM0", interface="slcan", more=more)
