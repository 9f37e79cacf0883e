"""A trial by the robot's own service, through all bytes."""

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import pytest

from echogrid.emulation.world import World
from echogrid.emulation.worlds.arena import Arena
from echogrid.runtime.command_line import main
from echogrid.runtime.trials import byte_drive
from echogrid.runtime.trials.course import Course
from echogrid.runtime.trials.job import Job
from echogrid.runtime.trials.paths import begun

ROOM = ((0.0, 0.0, 6.0, 0.0), (6.0, 0.0, 6.0, 4.0), (6.0, 4.0, 0.0, 4.0), (0.0, 4.0, 0.0, 0.0))
PEN = ((0.6, 1.4, 0.6, 2.6), (0.6, 2.6, 1.8, 2.6), (1.8, 2.6, 1.8, 1.4), (1.8, 1.4, 0.6, 1.4))
JOB = Job("room", 1, "goto", "built-in", crosstalk=True, path="bytes")


@pytest.fixture
def drive_past(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., byte_drive.ByteDrive]]:
    """A drive eastward through a room of one's own."""

    def made(*walls: tuple[float, float, float, float], job: Job = JOB) -> byte_drive.ByteDrive:
        table = np.array((*ROOM, *walls))
        world = World("room", table, np.zeros(len(table), np.bool_), np.zeros((0, 3)))
        task = Course(Arena(world, (1.2, 2.0)), (1.2, 2.0, 0.2), (3.4, 2.0), 1.8, 0.0)
        monkeypatch.setattr(byte_drive, "course", lambda *_: task)
        return byte_drive.ByteDrive(job)

    yield made


def test_it_comes_to_the_goal_and_the_same_seed_gives_the_same_bits(drive_past) -> None:
    first, again, other = (drive_past(job=job).done() for job in (JOB, JOB, replace(JOB, seed=2)))
    assert first.outcome == "reached"
    assert not first.bumps
    assert 1.6 < first.travelled < 2.4
    assert first.spl > 0.75
    assert first.goal_error < 0.5
    assert first.pings > 50.0 * (first.time_s - 2.0)
    assert 0.02 < first.latency_s[0] < first.latency_s[1] < 0.2
    assert first == again
    assert first.digest != other.digest


def test_its_steps_are_told_as_those_of_any_drive(drive_past) -> None:
    drive = drive_past()
    verdict = drive.done()
    rows = drive.track.rows
    assert rows[0][0] == pytest.approx(0.02)
    assert rows[-1][0] == pytest.approx(verdict.time_s)
    assert rows[0][1:4] == pytest.approx((1.2, 2.0, 0.2))
    assert 0.4 < max(row[7] for row in rows) <= 0.5
    assert {ping.seat for ping in drive._fired} == set(range(12))


def test_who_gives_up_is_stuck_and_touches_nothing(drive_past) -> None:
    verdict = drive_past(*PEN).done()
    assert verdict.outcome == "stuck"
    assert not verdict.bumps
    assert verdict.time_s <= 21.0


def test_its_name_and_its_place_in_the_table_say_what_went_through_bytes() -> None:
    assert JOB.name == "room-1-goto-built-in-none-crosstalk-bytes"
    assert JOB.driver == "goto by bytes"
    assert Job("room", 1, "vff").driver == "vff"


def test_a_path_that_is_not_is_told() -> None:
    with pytest.raises(KeyError, match="telepathy"):
        begun(replace(JOB, path="telepathy"))


@pytest.mark.parametrize("option", [("--pilots", "vff"), ("--rig", "ring-16"), ("--fault", "dead")])
def test_what_does_not_go_with_bytes_is_misuse(
    capsys: pytest.CaptureFixture[str], option: tuple[str, str]
) -> None:
    assert main(["trial", "--bytes", *option]) == 2
    assert f"leave out {option[0]}" in capsys.readouterr().err
