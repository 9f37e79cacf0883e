from collections.abc import Sequence
from errno import EACCES, EINVAL, EIO, ENODEV, ENOENT, ENOTUNIQ, ENXIO, EREMOTEIO, ETIMEDOUT
from itertools import pairwise
from math import isnan

from hypothesis import given
from hypothesis.strategies import binary, integers, lists, one_of, sampled_from, tuples
from pytest import approx, mark, raises

from echogrid.drivers.bus import IioRead, IioResult
from echogrid.drivers.device import Line, State
from echogrid.drivers.iio import ENDLESS_NS, FIRED_WITHIN_NS, Iio
from echogrid.drivers.iio_kernel import KERNEL_DRIVERS
from echogrid.drivers.readings import Outcome, RangeReading, Reading
from echogrid.drivers.role import RangerRole, Slot

MS = 1_000_000
SPEED = 343.5
SLOT = Slot(100 * MS, 30 * MS)
ROLE = RangerRole("front", 0.05, 4.0, SLOT, SPEED)
FILE_NS = 20_000
RAW = "in_distance_raw"

Said = tuple[bytes, int, int]
"""Text, errno, ms."""


class Bench:
    """A kernel played by hand: its files, and what reading the distance brings."""

    def __init__(
        self,
        name: bytes = b"srf04\n",
        scale: bytes = b"0.001000\n",
        settings: Iio.Settings | None = None,
        role: RangerRole = ROLE,
    ) -> None:
        self.device = Iio(role, settings or Iio.Settings())
        self.files: dict[str, tuple[bytes, int]] = {"name": (name, 0), "in_distance_scale": (scale, 0)}
        self.said: Said = b"1500\n", 0, 10
        self.now_ns = 0
        self.fired_ns: list[int] = []
        self.read: list[str] = []
        self.readings: list[Reading] = []

    def run(self, for_ns: int) -> "Bench":
        """Let the device do what it wants until so much time is over."""
        end_ns = self.now_ns + for_ns
        received: list[IioResult] = []
        while True:
            step = self.device.step(self.now_ns, received)
            self.readings += step.readings
            received = [self.result(transfer) for transfer in step.send]
            if not received:
                if step.deadline_ns > end_ns:
                    break
                self.now_ns = max(self.now_ns, step.deadline_ns)
        self.now_ns = max(self.now_ns, end_ns)
        return self

    def result(self, transfer: IioRead) -> IioResult:
        start_ns = self.now_ns
        self.read.append(transfer.attribute)
        if transfer.attribute == RAW:
            self.fired_ns.append(start_ns)
            data, errno, after_ms = self.said
            self.now_ns += after_ms * MS
        else:
            data, errno = self.files[transfer.attribute]
            self.now_ns += FILE_NS
        return IioResult(transfer, start_ns, self.now_ns, data, errno)

    def ranged(self) -> list[RangeReading]:
        return [reading for reading in self.readings if isinstance(reading, RangeReading)]

    @property
    def state(self) -> State:
        return self.device.health(self.now_ns).state

    @property
    def message(self) -> str:
        return self.device.health(self.now_ns).message


def srf08() -> Bench:
    return Bench(b"srf08\n", b"0.010000\n")


def test_name_and_scale_are_read_before_it_fires_in_its_slot() -> None:
    bench = Bench().run(300 * MS)
    assert bench.read == ["name", "in_distance_scale", RAW, RAW, RAW]
    assert bench.fired_ns == [30 * MS, 130 * MS, 230 * MS]


def test_a_ping_is_a_single_read_of_the_device_that_was_named() -> None:
    device = Iio(ROLE, Iio.Settings(device="hc-sr04-front"))
    (name,) = device.step(0, []).send
    assert name == IioRead("hc-sr04-front", "name")


@mark.parametrize(
    ("name", "scale", "raw", "metres"),
    [
        (b"srf04\n", b"0.001000\n", b"1500\n", 1.5),
        (b"ping\n", b"0.001000\n", b"1500\n", 1.5),
        (b"srf08\n", b"0.010000\n", b"77\n", 0.77 * 343.5 / 343.0),
        (b"maxbotix-mb1232\n", b"0.010000\n", b"250\n", 2.5 * 343.5 / 344.8),
    ],
)
def test_raw_values_become_metres_by_the_scale(name: bytes, scale: bytes, raw: bytes, metres: float) -> None:
    bench = Bench(name, scale)
    bench.said = raw, 0, 10
    reading = bench.run(200 * MS).ranged()[0]
    assert (reading.outcome, reading.distance) == (Outcome.ECHO, approx(metres))
    assert reading.raw == raw.strip()


def test_metres_are_corrected_for_the_speed_of_sound_in_the_air() -> None:
    cold = RangerRole("front", 0.05, 4.0, SLOT, 331.3)
    assert Bench(role=cold).run(100 * MS).ranged()[0].distance == approx(1.5 * 331.3 / 343.5)
    by_hand = Bench(settings=Iio.Settings(speed_of_sound_m_s=331.3), role=cold)
    assert by_hand.run(100 * MS).ranged()[0].distance == approx(1.5)


def test_the_sound_left_within_a_millisecond_from_the_beginning_of_the_read() -> None:
    (reading,) = Bench().run(100 * MS).ranged()
    fired_ns = reading.stamp_ns - round(1.5 / SPEED * 1e9)
    assert fired_ns - 30 * MS == reading.stamp_error_ns == FIRED_WITHIN_NS // 2


@mark.parametrize(
    ("said", "outcome"),
    [
        ((b"30\n", 0, 2), Outcome.TOO_CLOSE),
        ((b"0\n", 0, 2), Outcome.TOO_CLOSE),
        ((b"3999\n", 0, 25), Outcome.ECHO),
        ((b"4000\n", 0, 25), Outcome.NO_ECHO),
        ((b"6526\n", 0, 39), Outcome.NO_ECHO),
        ((b"", EIO, 45), Outcome.NO_ECHO),
        ((b"", ETIMEDOUT, 51), Outcome.NO_ECHO),
        ((b"", ETIMEDOUT, 20), Outcome.INVALID),
        ((b"6946\n", 0, 41), Outcome.INVALID),
        ((b"-5\n", 0, 41), Outcome.INVALID),
        ((b"", EACCES, 1), Outcome.INVALID),
    ],
)
def test_what_an_srf04_says_has_its_meaning(said: Said, outcome: Outcome) -> None:
    bench = Bench()
    bench.said = said
    (reading,) = bench.run(100 * MS).ranged()
    assert reading.outcome is outcome
    assert isnan(reading.distance) == (outcome is not Outcome.ECHO)
    assert bool(reading.reason) == (outcome is Outcome.INVALID)


def test_a_reach_beyond_that_of_an_hc_sr04_does_not_make_its_silence_an_echo() -> None:
    bench = Bench(role=RangerRole("front", 0.05, 6.9, SLOT, SPEED))
    bench.said = b"6183\n", 0, 37
    assert bench.run(100 * MS).ranged()[0].outcome is Outcome.NO_ECHO


@mark.parametrize(
    ("said", "outcome", "state"),
    [
        ((b"0\n", 0, 40), Outcome.NO_ECHO, State.WELL),
        ((b"65535\n", 0, 40), Outcome.INVALID, State.FAULTY),
        ((b"", EIO, 57), Outcome.INVALID, State.MISSING),
        ((b"", EREMOTEIO, 1), Outcome.INVALID, State.MISSING),
        ((b"", ENXIO, 1), Outcome.INVALID, State.MISSING),
        ((b"", ETIMEDOUT, 100), Outcome.INVALID, State.MISSING),
        ((b"", EINVAL, 40), Outcome.INVALID, State.FAULTY),
    ],
)
def test_what_an_srf08_says_has_its_meaning(said: Said, outcome: Outcome, state: State) -> None:
    bench = srf08()
    bench.said = said
    (reading,) = bench.run(100 * MS).ranged()
    assert (reading.outcome, bench.state) == (outcome, state)


def test_the_765_of_a_maxbotix_is_no_echo_however_far_it_shall_hear() -> None:
    bench = Bench(b"maxbotix-mb1232\n", b"0.010000\n", role=RangerRole("rear", 0.2, 10.0, SLOT, SPEED))
    bench.said = b"765\n", 0, 75
    assert bench.run(240 * MS).ranged()[0].outcome is Outcome.NO_ECHO


def test_the_least_value_of_a_maxbotix_means_as_near_as_that_or_nearer() -> None:
    for raw, outcome in ((b"20\n", Outcome.TOO_CLOSE), (b"21\n", Outcome.ECHO)):
        bench = Bench(b"maxbotix-mb1232\n", b"0.010000\n")
        bench.said = raw, 0, 75
        assert bench.run(240 * MS).ranged()[0].outcome is outcome


def test_settings_say_otherwise_what_no_echo_is() -> None:
    settings = Iio.Settings(no_echo_raw=3000, no_echo_errors=())
    for said, outcome in (((b"3000\n", 0, 20), Outcome.NO_ECHO), ((b"", EIO, 45), Outcome.INVALID)):
        bench = Bench(settings=settings)
        bench.said = said
        assert bench.run(100 * MS).ranged()[0].outcome is outcome
    bench = srf08()
    bench.device = Iio(ROLE, Iio.Settings(no_echo_errors=("EIO",)))
    bench.said = b"", EIO, 57
    assert bench.run(100 * MS).ranged()[0].outcome is Outcome.NO_ECHO


def test_a_ranger_that_is_not_wired_is_missing_and_the_message_tells_where_to_look() -> None:
    bench = Bench()
    bench.said = b"", ETIMEDOUT, 20
    bench.run(500 * MS)
    assert bench.state is State.MISSING
    assert "check its power and both its wires" in bench.message
    bench.said = b"1500\n", 0, 10
    assert bench.run(200 * MS).state is State.WELL


def test_behind_a_pulse_without_an_end_it_rests_longer() -> None:
    bench = Bench()
    bench.said = b"", ETIMEDOUT, 51
    bench.run(1000 * MS)
    assert bench.state is State.WELL
    assert all(later - first > ENDLESS_NS for first, later in pairwise(bench.fired_ns))
    bench.said = b"1500\n", 0, 10
    bench.run(400 * MS)
    bench.fired_ns.clear()
    bench.run(300 * MS)
    assert len(bench.fired_ns) == 3


@mark.parametrize(("name", "rest_ms"), [(b"srf04\n", 58), (b"srf08\n", 58), (b"maxbotix-mb1202\n", 98)])
@given(period_ms=integers(1, 200))
def test_it_never_pings_sooner_than_its_maker_allows(name: bytes, rest_ms: int, period_ms: int) -> None:
    bench = Bench(name, role=RangerRole("front", 0.05, 4.0, Slot(period_ms * MS, 0), SPEED))
    bench.run(1000 * MS)
    assert len(bench.fired_ns) > 2
    assert all(later - first >= rest_ms * MS for first, later in pairwise(bench.fired_ns))


@mark.parametrize(
    ("settings", "ping_ms", "rest_ms"),
    [
        (Iio.Settings("srf04"), 40, 58),
        (Iio.Settings("ping"), 20, 58),
        (Iio.Settings("maxbotix-mb1232"), 80, 98),
        (Iio.Settings("front"), 80, 98),
        (Iio.Settings("front", kernel_driver="srf04"), 40, 58),
        (Iio.Settings("srf04", kernel_driver="mb1232"), 80, 98),
    ],
)
def test_it_is_planned_as_its_settings_say_or_as_the_slowest(
    settings: Iio.Settings, ping_ms: int, rest_ms: int
) -> None:
    pace = Iio(ROLE, settings).pace(0)
    assert (pace.ping_ns, pace.rest_ns, pace.holds_bus) == (ping_ms * MS, rest_ms * MS, True)


@given(sampled_from(sorted(KERNEL_DRIVERS)))
def test_what_is_not_told_is_never_planned_quicker_than_it_turns_out(name: str) -> None:
    planned, known = Iio(ROLE, Iio.Settings("front")).pace(0), KERNEL_DRIVERS[name]
    assert planned.ping_ns >= known.ping_ns
    assert planned.rest_ns >= known.rest_ns


def test_another_kernel_driver_than_was_told_is_a_wrong_device() -> None:
    bench = Bench(b"maxbotix-mb1232\n", b"0.010000\n", Iio.Settings("front", kernel_driver="srf04"))
    bench.run(300 * MS)
    assert bench.state is State.WRONG_DEVICE
    assert "is a 'maxbotix-mb1232', not a 'srf04': set kernel_driver" in bench.message
    assert bench.fired_ns == []


def test_the_kernel_driver_that_was_told_may_be_named_without_its_maker() -> None:
    bench = Bench(b"maxbotix-mb1232\n", b"0.010000\n", Iio.Settings("front", kernel_driver="mb1232"))
    bench.said = b"150\n", 0, 80
    assert bench.run(300 * MS).state is State.WELL


def test_without_a_slot_it_pings_about_ten_times_a_second() -> None:
    bench = Bench(role=RangerRole("front", 0.05, 4.0, None, SPEED)).run(2000 * MS)
    assert 18 <= len(bench.fired_ns) <= 21


@mark.parametrize(
    ("errno", "state", "text"),
    [
        (ENODEV, State.MISSING, "no IIO device 'srf04': is its kernel driver loaded"),
        (ENOTUNIQ, State.CONFLICT, "several are called IIO device 'srf04': name one of them by"),
        (EACCES, State.MISSING, r"IIO device 'srf04': cannot be read \(EACCES\)"),
    ],
)
def test_why_it_cannot_be_set_up_is_told_and_it_is_tried_again(errno: int, state: State, text: str) -> None:
    bench = Bench()
    bench.files["name"] = b"", errno
    bench.run(1000 * MS)
    assert bench.fired_ns == []
    assert bench.state is state
    assert text.replace("\\", "") in bench.message
    bench.files["name"] = b"srf04\n", 0
    assert bench.run(2000 * MS).state is State.WELL


@mark.parametrize(
    ("name", "scale"),
    [
        ((b"bme280\n", 0), (b"", ENOENT)),
        ((b"vl53l0x\n", 0), (b"0.001000\n", 0)),
        ((b"srf04\n", 0), (b"", ENOENT)),
    ],
)
def test_what_is_no_ranger_is_a_wrong_device(name: tuple[bytes, int], scale: tuple[bytes, int]) -> None:
    bench = Bench()
    bench.files = {"name": name, "in_distance_scale": scale}
    bench.run(100 * MS)
    assert bench.state is State.WRONG_DEVICE
    assert f"is a '{name[0].strip().decode()}', no ultrasonic ranger (srf04, ping," in bench.message


def test_a_device_that_the_kernel_has_lost_is_looked_for_again() -> None:
    bench = Bench().run(100 * MS)
    bench.said = b"", ENODEV, 0
    bench.files["name"] = b"", ENODEV
    bench.run(300 * MS)
    assert bench.state is State.MISSING
    assert bench.ranged()[-1].reason == "the kernel has lost it"
    bench.files["name"] = b"ping\n", 0
    bench.said = b"1500\n", 0, 10
    bench.run(2000 * MS)
    assert bench.state is State.WELL
    assert bench.read.count("in_distance_scale") == 2


def test_a_ping_under_way_when_the_port_is_lost_is_invalid() -> None:
    bench = Bench()
    device = bench.device
    step = device.step(0, [])
    while not any(read.attribute == RAW for read in step.send):
        received = [bench.result(read) for read in step.send]
        bench.now_ns = bench.now_ns if received else step.deadline_ns
        step = device.step(bench.now_ns, received)
    device.lost(bench.now_ns)
    (name,) = device.step(bench.now_ns, []).send
    assert name.attribute == "name"


def test_two_share_a_line() -> None:
    roles = [RangerRole(name, 0.05, 4.0, Slot(200 * MS, n * 100 * MS), SPEED) for n, name in enumerate("ab")]
    line: Line[IioResult, IioRead] = Line(
        "pins", [Iio(role, Iio.Settings(device=role.name)) for role in roles]
    )
    now_ns, received, readings = 0, list[IioResult](), list[Reading]()
    texts = {"name": b"srf04\n", "in_distance_scale": b"0.001000\n", RAW: b"1500\n"}
    while now_ns < 1000 * MS:
        step = line.step(now_ns, received)
        readings += step.readings
        received = [IioResult(read, now_ns, now_ns + 1, texts[read.attribute]) for read in step.send]
        now_ns = now_ns + 1 if received else step.deadline_ns
    assert [reading.sensor for reading in readings if isinstance(reading, RangeReading)] == list("babababab")


@mark.parametrize(
    ("keys", "text"),
    [
        ({"device": ""}, "device is ''"),
        ({"device": "../in"}, "device is '../in': expected a name, without a folder"),
        ({"kernel_driver": "hc-sr04"}, "kernel_driver is 'hc-sr04': expected one of srf04, ping,"),
        ({"no_echo_raw": 0}, "no_echo_raw is 0: expected 1 to 1000000"),
        (
            {"no_echo_errors": ("EIO", "ETIMEOUT")},
            "no_echo_errors has 'ETIMEOUT': expected names such as EIO",
        ),
        ({"speed_of_sound_m_s": 34.3}, "speed_of_sound_m_s is 34.3: expected 300.0 to 400.0"),
    ],
)
def test_impossible_settings_are_refused_by_name(keys: dict[str, object], text: str) -> None:
    with raises(ValueError, match=text):
        Iio.Settings(**keys)  # type: ignore[arg-type]  # that is the point


WORDS = one_of(binary(max_size=12), integers(-10, 80_000).map(lambda raw: b"%d\n" % raw))
NAMES = [b"srf04", b"srf08"]
SAID: Sequence[int] = (0, 0, 0, EIO, ETIMEDOUT, ENODEV, EINVAL, 9999)


@given(lists(tuples(WORDS, sampled_from(SAID), integers(0, 100)), max_size=20), sampled_from(NAMES))
def test_whatever_the_kernel_says_each_ping_gives_one_possible_reading(said: list[Said], name: bytes) -> None:
    bench = Bench(name)
    for each in said:
        bench.said = each
        bench.run(100 * MS)
    bench.said = b"150\n", 0, 10
    bench.run(400 * MS)
    assert len(bench.fired_ns) == len(bench.readings)
    for reading in bench.ranged():
        assert (reading.outcome is Outcome.ECHO) == (ROLE.nearest <= reading.distance < ROLE.farthest)
    assert bench.state is State.WELL
