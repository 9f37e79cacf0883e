from errno import EINVAL, EIO, ENODEV, ENOENT, ENXIO, ETIMEDOUT
from random import Random
from typing import Any

from hypothesis import given
from hypothesis.strategies import floats, sampled_from
from pytest import approx, mark, raises

from echogrid.drivers.bus import NEVER_NS, IioRead, IioResult
from echogrid.emulation.buses.iio_bus import IioBus
from echogrid.emulation.devices.iio_device import IioDevice
from echogrid.emulation.devices.iio_ranger import IioOptions, iio_ranger
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.errors import RobotSpecError, UnknownVerbError
from echogrid.emulation.robot import BusSpec, EmulatedRobot, RangerSpec, RobotSpec
from echogrid.emulation.scene import Echo

MS = 1_000_000
SPEED = 343.5
"""m/s: the kernel's."""
RAW, SCALE = "in_distance_raw", "in_distance_scale"
KINDS = ("srf04", "ping", "srf08", "maxbotix-mb1232")


def of_each(*columns: tuple[Any, ...]) -> list[tuple[Any, ...]]:
    """Rows for the kinds, in their order."""
    return list(zip(KINDS, *columns, strict=True))


def room(*distances: float, speed: float = SPEED, fired_ns: list[int] | None = None) -> Surroundings:
    echoes = tuple(Echo(distance, 40.0, "wall") for distance in distances)
    pings = [] if fired_ns is None else fired_ns
    return Surroundings(lambda fire_ns: echoes, speed, ping=pings.append)


def ranger(kind: str, *distances: float, speed: float = SPEED, no_echo_ns: int = 0) -> IioDevice:
    options = IioOptions(device=kind, no_echo_ns=no_echo_ns)
    return iio_ranger("front", room(*distances, speed=speed), Random(1), options)


class Host:
    """Reads one file after the other, and waits for each."""

    def __init__(self, *devices: IioDevice) -> None:
        self.bus = IioBus("pins", devices)
        self.bus.switch_on(0)
        self.device = devices[0]
        self.now_ns = 0

    def read(self, attribute: str = RAW, device: str = "") -> IioResult:
        self.bus.send([IioRead(device or self.device.device, attribute)], self.now_ns)
        while not (results := self.bus.take(self.now_ns)):
            self.now_ns = self.bus.next_event_ns()
        return results[0]

    def raw(self) -> int:
        return int(self.read().data)

    def wait(self, ms: float) -> None:
        self.now_ns += round(ms * MS)


def took_ms(result: IioResult) -> float:
    return (result.end_ns - result.start_ns) / MS


@mark.parametrize(("kind", "scale"), of_each((b"0.001000\n", b"0.001000\n", b"0.010000\n", b"0.010000\n")))
def test_name_and_scale_are_those_of_the_kernel(kind: str, scale: bytes) -> None:
    host = Host(ranger(kind))
    assert host.read("name").data == kind.encode() + b"\n"
    assert host.read(SCALE).data == scale
    assert host.read("in_voltage0_raw").errno == ENOENT


@mark.parametrize(("kind", "text"), of_each((b"1500\n", b"1500\n", b"150\n", b"151\n")))
def test_a_wall_at_a_metre_and_a_half_reads_as_the_text(kind: str, text: bytes) -> None:
    result = Host(ranger(kind, 1.5001)).read()
    assert (result.data, result.errno) == (text, 0)


@given(sampled_from(("srf04", "ping")), floats(0.05, 2.85), floats(310.0, 360.0))
def test_a_pulse_is_the_time_of_flight_and_its_millimetres_are_those_of_20_degrees(
    kind: str, distance: float, speed: float
) -> None:
    raw = Host(ranger(kind, distance, speed=speed)).raw()
    assert raw == approx(1000 * distance * SPEED / speed - 0.5, abs=0.6)


def test_a_ping_hears_nothing_later_than_its_longest_pulse() -> None:
    assert Host(ranger("ping", 2.9, speed=310.0)).read().data == b"3177\n"


@mark.parametrize(("kind", "text"), of_each((b"6526\n", b"3177\n", b"0\n", b"765\n")))
def test_what_is_out_of_reach_reads_as_each_tells_it(kind: str, text: bytes) -> None:
    assert Host(ranger(kind)).read().data == text
    assert Host(ranger(kind, 9.0)).read().data == text


@mark.parametrize(("kind", "raw"), of_each((19, 19, 3, 20)))
def test_what_is_nearer_than_each_can_tell_reads_as_its_least(kind: str, raw: int) -> None:
    assert Host(ranger(kind, 0.005)).raw() == raw


@mark.parametrize(
    ("no_echo_ms", "text", "errno", "ms"),
    [
        (40.4, b"6938\n", 0, 40.9),
        (40.5, b"", EIO, 41.0),
        (49.9, b"", EIO, 50.4),
        (50.1, b"", ETIMEDOUT, 50.5),
        (200.0, b"", ETIMEDOUT, 50.5),
    ],
)
def test_a_long_pulse_of_a_clone_is_the_kernels_error(
    no_echo_ms: float, text: bytes, errno: int, ms: float
) -> None:
    result = Host(ranger("srf04", no_echo_ns=round(no_echo_ms * MS))).read()
    assert (result.data, result.errno) == (text, errno)
    assert took_ms(result) == approx(ms)


def test_a_trigger_while_the_last_pulse_lasts_does_nothing() -> None:
    host = Host(ranger("srf04", no_echo_ns=200 * MS))
    host.read()
    assert host.read().errno == ETIMEDOUT
    assert host.now_ns < 100 * MS
    host.now_ns = 201 * MS
    late = host.read()
    assert took_ms(late) > 50


@mark.parametrize(("kind", "ms"), of_each((0.5, 0.75, 0.3, 0.3)))
def test_it_pings_shortly_after_the_read_began(kind: str, ms: float) -> None:
    fired_ns: list[int] = []
    device = iio_ranger("front", room(1.0, fired_ns=fired_ns), Random(1), IioOptions(device=kind))
    host = Host(device)
    host.wait(7)
    host.read()
    assert fired_ns == [7 * MS + round(ms * MS)]


@mark.parametrize(("kind", "ms"), of_each((23.8, 18.2, 36.6, 75.6)))
def test_a_read_lasts_as_long_as_the_ranger_listens(kind: str, ms: float) -> None:
    assert took_ms(Host(ranger(kind, 1.0)).read()) == approx(ms, abs=0.1)


@mark.parametrize("kind", KINDS)
def test_nothing_can_make_a_read_last_longer_than_the_kernel_waits(kind: str) -> None:
    for verb in ("off", "delayed", "slow", "garbage", "intermittent"):
        host = Host(ranger(kind, 1.0))
        host.device.fault(verb, 0)
        assert max(took_ms(host.read()) for _ in range(20)) < 101


def test_reads_go_one_after_the_other() -> None:
    rear = iio_ranger("rear", room(1.0), Random(2), IioOptions(device="rear"))
    host = Host(ranger("srf04", 1.5), rear)
    host.bus.send([IioRead("srf04", RAW), IioRead("rear", RAW)], 0)
    host.now_ns = 100 * MS
    first, second = host.bus.take(host.now_ns)
    assert (first.data, second.data) == (b"1500\n", b"1000\n")
    assert second.start_ns == first.end_ns


def test_a_device_that_is_not_there_is_enodev() -> None:
    assert Host(ranger("srf04")).read(device="left").errno == ENODEV


@mark.parametrize(
    ("kind", "errno", "ms"),
    of_each((ETIMEDOUT, ETIMEDOUT, ENXIO, ENXIO), (20.0, 20.0, 0.3, 0.3)),
)
def test_without_power_it_does_not_answer_and_comes_back(kind: str, errno: int, ms: float) -> None:
    host = Host(ranger(kind, 1.0))
    host.device.fault("off", 0, 500 * MS)
    result = host.read()
    assert (result.errno, took_ms(result)) == (errno, approx(ms))
    host.now_ns = 500 * MS
    assert host.read().errno == 0


@mark.parametrize(("kind", "errno"), of_each((ETIMEDOUT, ETIMEDOUT, ENXIO, ENXIO)))
def test_a_ping_under_way_when_the_power_goes_is_an_error(kind: str, errno: int) -> None:
    host = Host(ranger(kind, 1.0))
    host.bus.send([IioRead(kind, RAW)], 0)
    host.bus.advance(2 * MS)
    host.device.fault("off", 2 * MS)
    while not (results := host.bus.take(host.now_ns)):
        host.now_ns = host.bus.next_event_ns()
    assert results[0].errno == errno


def test_the_name_can_be_read_without_power_and_not_without_the_device() -> None:
    host = Host(ranger("srf04", 1.0))
    host.device.fault("off", 0)
    assert host.read("name").errno == 0
    host.device.fault("unplug", host.now_ns)
    assert host.read("name").errno == host.read().errno == ENODEV
    host.device.clear(host.now_ns)
    assert host.raw() == 1000


@mark.parametrize(("kind", "errno"), of_each((ETIMEDOUT, ETIMEDOUT, EIO, ETIMEDOUT)))
def test_a_ranger_that_is_late_by_a_fifth_of_a_second_is_too_late_for_the_kernel(
    kind: str, errno: int
) -> None:
    host = Host(ranger(kind, 1.0))
    host.device.fault("delayed", 0)
    assert host.read().errno == errno


def test_a_slow_chip_is_never_ready_for_the_kernel_and_a_slow_pulse_is_only_late() -> None:
    for kind, errno in (("srf08", EIO), ("maxbotix-mb1232", ETIMEDOUT), ("srf04", 0)):
        host = Host(ranger(kind, 1.0))
        host.device.fault("slow", 0)
        assert host.read().errno == errno


def test_a_storm_is_known_only_where_somebody_acknowledges() -> None:
    host = Host(ranger("srf08", 1.0))
    host.device.fault("nack_storm", 0)
    errors = [host.read().errno for _ in range(100)]
    assert set(errors) == {0, EIO}
    assert 50 < errors.count(EIO) < 90
    with raises(UnknownVerbError, match="no fault 'nack_storm'"):
        ranger("ping").fault("nack_storm", 0)


def test_a_noisy_line_has_pulses_of_any_length() -> None:
    host = Host(ranger("srf04", 1.0))
    host.device.fault("garbage", 0)
    results = [host.read() for _ in range(100)]
    assert {result.errno for result in results} == {0, EIO, ETIMEDOUT}
    assert len({result.data for result in results}) > 20


def test_random_registers_may_look_like_an_error_of_a_maxbotix() -> None:
    host = Host(ranger("maxbotix-mb1232", 1.0))
    host.device.fault("garbage", 0)
    assert {host.read().errno for _ in range(50)} == {0, EINVAL}


def test_wrong_and_stuck_rangers_lie() -> None:
    host = Host(ranger("srf04", 1.0))
    assert host.raw() == 1000
    host.device.fault("wrong", host.now_ns)
    assert host.raw() == 1500


def test_unplugged_the_drivers_are_gone_and_a_read_under_way_with_them() -> None:
    host = Host(ranger("srf04", 1.0))
    host.bus.send([IioRead("srf04", RAW), IioRead("srf04", RAW)], 0)
    host.bus.advance(5 * MS)
    host.bus.fault("unplug", 5 * MS, 100 * MS)
    assert not host.bus.present
    host.now_ns = 200 * MS
    assert host.bus.take(host.now_ns) == ()
    assert host.bus.next_event_ns() == NEVER_NS
    assert host.raw() == 1000


@mark.parametrize(
    ("options", "kind"),
    [
        (IioOptions(), "srf04"),
        (IioOptions("ping"), "ping"),
        (IioOptions("front"), "srf04"),
        (IioOptions("front", "srf08"), "srf08"),
    ],
)
def test_what_it_is_follows_from_its_name_unless_it_is_told(options: IioOptions, kind: str) -> None:
    assert options.kind == kind


def robot(*rangers: RangerSpec) -> EmulatedRobot:
    buses = (BusSpec("pins", "iio"),)
    return EmulatedRobot(
        RobotSpec(0.1, 0.4, buses, rangers, ()), lambda _: room(1.0), lambda _side: lambda _now: 0.0
    )


def spec(name: str, **options: int | float | str) -> RangerSpec:
    return RangerSpec(name, "iio", "pins", 0.0, 0.0, 0.0, options)


def test_a_robot_may_have_several_with_names_of_their_own() -> None:
    robot(spec("a", device="left"), spec("b", device="right"))
    with raises(RobotSpecError, match="pins: a and b share the device 'srf04'"):
        robot(spec("a"), spec("b"))
    with raises(
        RobotSpecError, match="a: kernel_driver 'srf05' is none of those emulated: srf04, ping, srf08"
    ):
        robot(spec("a", kernel_driver="srf05"))
