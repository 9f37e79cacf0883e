"""What a [[sensor]] may say for itself."""

from pathlib import Path

import pytest

from echogrid.mapping.ranger import NoEcho
from echogrid.runtime import recording
from echogrid.runtime.config import Config
from echogrid.runtime.errors import UsageError
from echogrid.runtime.toml_edit import with_values

from . import recordings


def configured(folder: Path, lines: str) -> Config:
    """The configuration whose first sensor has these lines."""
    robot = recordings.ROBOT.replace('name = "front"\n', f'name = "front"\n{lines}\n')
    return recording.read_simple(recordings.write(folder, robot=robot)).config


def test_a_sensor_s_tolerance_silence_and_detection_are_its_ranger_s(tmp_path: Path) -> None:
    told = 'tolerance_m = 0.2\nsilence = "clear"\ndetection = 0.9'
    front, left = (sensor.ranger() for sensor in configured(tmp_path, told).sensor)
    assert (front.tolerance, front.no_echo, front.detection) == (0.2, NoEcho.CLEAR, 0.9)
    assert (left.tolerance, left.no_echo, left.detection) == (None, None, None)


def test_a_driver_s_own_no_echo_stays_the_driver_s(tmp_path: Path) -> None:
    told = 'driver = "maxbotix"\nno_echo = 500\nsilence = "ignore"'
    front = configured(tmp_path, told).sensor[0]
    assert front.settings == {"no_echo": 500}
    assert front.silence is NoEcho.IGNORE


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ("tolerance_m = 0.0", "`tolerance_m` must be above 0"),
        ("detection = 1.0", "`detection` must lie in 0...0.99"),
        ("detection = -0.1", "`detection` must lie in 0...0.99"),
        ('silence = "loud"', "expected one of ignore, weak, clear"),
    ],
)
def test_what_is_impossible_is_told(tmp_path: Path, lines: str, message: str) -> None:
    with pytest.raises(UsageError, match=message):
        configured(tmp_path, lines)


def test_a_text_is_written_with_its_quotes_and_a_comment_stays() -> None:
    text = '[map]\nmodel = "murphy" # printed\n'
    assert with_values(text, "map", {"model": "empirical", "model_file": "a.json"}) == (
        '[map]\nmodel = "empirical" # printed\nmodel_file = "a.json"\n'
    )
