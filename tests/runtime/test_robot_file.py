from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from echogrid.mapping.sonar_model import NoEcho
from echogrid.runtime import assembly, robot_file
from echogrid.runtime.config import Config
from echogrid.runtime.emulated import DEFAULT_ROBOT, emulated_robot
from echogrid.runtime.errors import UsageError

BUILT_IN = DEFAULT_ROBOT.read_text()
TEXTS = st.lists(
    st.sampled_from(BUILT_IN.splitlines())
    | st.from_regex(r"\[\[?(robot|sensor|wheel|bus|map|firing)\]?\]", fullmatch=True)
    | st.from_regex(
        r"(name|driver|bus|x_m|rate_hz|groups) = (\[*1\]*|nan|true|\"a\"|1e999|\{\}|-1)", fullmatch=True
    ),
    max_size=40,
).map("\n".join)


def checked(path: Path) -> None:
    """As a run reads it."""
    config = robot_file.load(path)
    with robot_file.located(path):
        assembly.parts(config)


def wrong(path: Path, text: str, check: Callable[[Path], object] = robot_file.load) -> list[str]:
    """What is wrong with that text, without the file's path."""
    path.write_text(text)
    with pytest.raises(UsageError) as caught:
        check(path)
    assert str(caught.value) == "\n".join(caught.value.problems)
    assert all(problem.startswith(str(path)) for problem in caught.value.problems)
    return [problem.removeprefix(str(path)) for problem in caught.value.problems]


def line(text: str, part: str) -> int:
    """The first line with that part, from 1."""
    return next(number for number, each in enumerate(text.splitlines(), 1) if part in each)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "robot.toml"


def test_the_built_in_robot_is_valid_and_fit_to_run() -> None:
    checked(DEFAULT_ROBOT)
    config = robot_file.load(DEFAULT_ROBOT)
    assert (len(config.sensor), len(config.wheel), len(config.bus)) == (12, 2, 6)
    assert config.map.no_echo is NoEcho.WEAK


def test_the_manual_s_smallest_robot_is_fit_to_run(path: Path) -> None:
    manual = Path(__file__).parents[2] / "docs/robot-toml.md"
    path.write_text(manual.read_text(encoding="utf-8").split("```toml\n")[1].split("```")[0])
    checked(path)
    config = robot_file.load(path)
    assert (len(config.sensor), len(config.wheel)) == (1, 2)
    emulated_robot(config, 0, 1)


def test_one_channel_of_two_can_interfaces_is_two_ports(path: Path) -> None:
    bus = '\n[[bus]]\nname = "{0}"\nkind = "can"\ninterface = "{0}"\nport = "0"\n'
    path.write_text(BUILT_IN + bus.format("pcan") + bus.format("kvaser"))
    assert len(robot_file.load(path).bus) == 8


def test_all_mistakes_are_told_at_once_each_with_its_line(path: Path) -> None:
    text = BUILT_IN.replace("rate_hz = 50.0", "rate_hz = 5000.0").replace("gap_ms", "gap_mss")
    text = text.replace("track_m = 0.32", "track_m = true").replace('kind = "can"', 'kind = "cam"')
    assert wrong(path, text) == [
        f":{line(text, 'track_m')}: robot.track_m: expected a number, not True",
        f":{line(text, '[loop]')}: loop: `rate_hz` must lie in 1...1000",
        f":{line(text, 'gap_mss')}: firing: unknown key `gap_mss` (did you mean `gap_ms`?)",
        f":{line(text, 'cam')}: bus[1].kind: expected one of serial, i2c, can, iio, not 'cam' "
        "(did you mean `can`?)",
    ]


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("yaw_deg = 45.0\n", "", "sensor[1]: missing key `yaw_deg`"),
        ("yaw_deg = 45.0", "yaw_deg = nan", "sensor[1].yaw_deg: expected a number, not nan"),
        ('name = "ring_45"', 'name = "ring_0"', "sensor[1]: `name` is taken: 'ring_0' stands there already"),
        (
            'name = "ring_45"',
            'name = "left"',
            "sensor[1]: `name` is taken: there is a [[wheel]] named 'left'",
        ),
        ('name = "ring_45"', 'name = " a"', "sensor[1]: `name` must be printable, without blanks around it"),
        (
            'bus = "ring_bus"\naddress = 0x71',
            'bus = "ringbus"',
            "there is no [[bus]] named 'ringbus' (did you mean",
        ),
        (
            'bus = "ring_bus"\naddress = 0x71',
            'bus = "mp"',
            "there is no [[bus]] named 'mp' (there are: ring_bus, wheel_bus, front_left_line, ",
        ),
        (
            'port = "rear_left_line"',
            'port = "front_left_line"',
            "bus[4]: `port` is taken: 'front_left_line' is that of bus 'front_left_line'",
        ),
        (
            'driver = "srf08"\nbus = "ring_bus"\naddress = 0x71',
            'device = "front"',
            "a driver's own keys need `driver`, which is missing",
        ),
        ('"ring_45", "ring_225"', '"ring_46", "ring_225"', "firing.groups: there is no [[sensor]] named"),
        ('"ring_45", "ring_225"', '"ring_0", "ring_45"', "firing.groups: 'ring_0' stands in two groups"),
        ('["ring_45", "ring_225"]', "[]", "firing.groups: a group without rangers: take it out"),
        (
            'name = "right"',
            'name = "middle"',
            "wheel[1].name: expected one of left, right, drive, steering, not 'middle'",
        ),
        ('name = "right"', 'name = "left"', "wheel[1]: `name` is taken"),
        ("height_m = 40.0\n", "", "map: `width_m` and `height_m` go together"),
    ],
)
def test_a_mistake_is_told_with_line_key_reason_and_hint(
    path: Path, old: str, new: str, problem: str
) -> None:
    assert old in BUILT_IN
    assert any(problem in each for each in wrong(path, BUILT_IN.replace(old, new, 1)))


def test_everything_that_keeps_a_robot_from_running_is_told_at_once_with_its_line(path: Path) -> None:
    text = BUILT_IN.replace("address = 0x71", "adress = 0x71\nzigzag = 1").replace(
        "address = 0x72", "address = 32"
    )
    text = text.replace('"a02yyuw"\nbus = "rear_left_line"', '"a02yyv"\nbus = "rear_left_line"')
    text = text.replace('bus = "front_left_line"\nlag', 'bus = "ring_bus"\nlag')
    text = text.replace("width_m = 40.0\nheight_m = 40.0\n", "").replace("track_m = 0.32\n", "")
    assert wrong(path, text, checked) == [
        f":{line(text, '[robot]')}: robot: `wheel_radius_m` and `track_m` are needed for wheel odometry",
        f":{line(text, '[map]')}: map: a run needs `width_m` and `height_m`",
        f":{line(text, 'adress')}: sensor[1]: unknown key `adress` (did you mean `address`?)",
        f":{line(text, 'zigzag')}: sensor[1]: unknown key `zigzag`",
        f":{line(text, 'address = 32') - 4}: sensor[2]: address is 0x20: expected 0x70 to 0x7f (7 bit)",
        f":{line(text, 'a02yyuw') + 1}: sensor[8].bus: a02yyuw speaks serial, but bus 'ring_bus' is i2c",
        f":{line(text, 'a02yyv')}: sensor[10].driver: unknown driver 'a02yyv' (did you mean 'a02yyuw'?)",
    ]


def test_a_recording_needs_no_driver_that_is_known_here(path: Path) -> None:
    path.write_text(BUILT_IN.replace('"srf08"', '"of another package"'))
    assert robot_file.load(path).sensor[0].driver == "of another package"


@pytest.mark.parametrize(
    "junk", ["[robot", "a = ", "\ufeff[robot]", "[" * 5000, "a = " + "1" * 5000, "x = {y = 1}", ""]
)
def test_what_is_no_robot_is_told_in_one_line_each(path: Path, junk: str) -> None:
    assert wrong(path, junk)


def test_a_file_that_is_no_text_is_told(path: Path) -> None:
    path.write_bytes(b"\xff\xfe\x00binary")
    with pytest.raises(UsageError, match="not TOML"):
        robot_file.load(path)


def test_a_missing_file_is_told_with_what_it_is_for(path: Path) -> None:
    with pytest.raises(UsageError, match=r"No such file .*a robot is described by a robot.toml"):
        robot_file.load(path)


def test_a_folder_is_no_file(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="directory"):
        robot_file.load(tmp_path)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(TEXTS)
def test_any_text_gives_a_configuration_or_a_usage_error(path: Path, text: str) -> None:
    path.write_text(text)
    try:
        config = robot_file.load(path)
    except UsageError as error:
        assert error.problems
        return
    assert isinstance(config, Config)
    try:
        with robot_file.located(path):
            assembly.parts(config)
    except UsageError as error:
        assert error.problems
