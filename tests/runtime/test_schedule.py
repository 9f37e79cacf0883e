import json
from dataclasses import replace
from pathlib import Path

import pytest

from echogrid.drivers.role import Slot
from echogrid.runtime import schedule, timeline
from echogrid.runtime.command_line import main
from echogrid.runtime.config import Config, FiringConfig
from echogrid.runtime.crosstalk_check import ring
from echogrid.runtime.emulated import DEFAULT_ROBOT
from echogrid.runtime.firing import Plan
from echogrid.runtime.firing_patterns import AUDIBLE_NS
from echogrid.runtime.lines import plan_of
from echogrid.runtime.robot_file import load

MS = 1_000_000
SPEED = 343.214
GROUPS = [
    ["ring_0", "ring_180"],
    ["ring_90", "ring_270"],
    ["ring_45", "ring_225"],
    ["ring_135", "ring_315"],
]


def facts(firing: FiringConfig) -> dict[str, object]:
    config = ring(firing)
    return schedule.facts(config, plan_of(config))


def window(firing: FiringConfig, listener: str, source: str) -> schedule.Window | None:
    config = ring(firing)
    found = schedule.windows(config, plan_of(config))
    return next((each for each in found if (each.listener, each.source) == (listener, source)), None)


def test_pings_are_counted_without_the_turns_that_only_listen() -> None:
    config = ring(FiringConfig(mode="together"))
    plan = plan_of(config)
    assert schedule.pings_per_s(plan) == pytest.approx(160.0)
    listening = {name: Slot(100 * MS, 0, listens_every=4) for name in plan.slots}
    assert schedule.pings_per_s(Plan(plan.pingers, plan.period_ns, (), listening)) == pytest.approx(120.0)
    assert schedule.pings_per_s(Plan()) == 0.0


def test_at_once_a_neighbour_may_be_heard_from_anywhere_and_the_opposite_one_not_at_all() -> None:
    heard = window(FiringConfig(mode="together"), "ring_0", "ring_1")
    assert heard is not None
    assert heard.bands == ((0.0, 6.0),)
    assert window(FiringConfig(mode="together"), "ring_0", "ring_8") is None


def test_who_fires_earlier_seems_nearer_by_half_of_the_way_of_sound() -> None:
    """ring_0 has its turn 25 ms before ring_1."""
    late = window(FiringConfig(mode="eeruf"), "ring_0", "ring_1")
    early = window(FiringConfig(mode="eeruf"), "ring_1", "ring_0")
    assert late is not None
    assert early is not None
    plan = plan_of(ring(FiringConfig(mode="eeruf")))
    for number, (after, before) in enumerate(zip(late.bands, early.bands, strict=True)):
        lag_ns = plan.slots["ring_1"].planned_ns(number) - plan.slots["ring_0"].planned_ns(number)
        assert after == pytest.approx((0.5e-9 * SPEED * lag_ns, 6.0), abs=1e-3)
        assert before == pytest.approx((0.0, 0.5e-9 * SPEED * (AUDIBLE_NS - lag_ns)), abs=1e-3)


def test_groups_with_all_the_time_they_need_hear_nothing_of_each_other() -> None:
    assert facts(FiringConfig())["crosstalk"] == []


def test_json_tells_all_of_the_built_in_robot(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["schedule", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["mode"], told["verify"], told["cycle_ms"], told["pings_per_s"]) == (
        "groups",
        False,
        280.0,
        28.571,
    )
    assert [group["rangers"] for group in told["groups"]] == GROUPS
    assert [group["begins_ms"] for group in told["groups"]] == [0.0, 70.0, 140.0, 210.0]
    assert told["by_themselves"] == ["front_left", "front_right", "rear_left", "rear_right"]
    assert {ranger["worst_gap_ms"] for ranger in told["rangers"]} == {280.0}


def rows(config: Config) -> list[str]:
    return list(timeline.text(config, plan_of(config)))


def test_the_chart_has_a_row_for_each_ranger_which_fires_at_its_time() -> None:
    config = load(DEFAULT_ROBOT)
    lines = rows(config)
    chart = lines[lines.index(next(line for line in lines if line.lstrip().startswith("ms "))) + 1 :]
    fired = {name: row.index("#") for name, row in (line.split(maxsplit=1) for line in chart[:8])}
    assert fired["ring_0"] == fired["ring_180"] == 0
    assert (fired["ring_90"], fired["ring_45"], fired["ring_135"]) == (14, 28, 42)
    assert chart[8] == "# fires, = listens; a column is 5 ms"


def test_with_changing_delays_the_chart_shows_the_whole_rotation() -> None:
    lines = rows(ring(FiringConfig(mode="eeruf")))
    chart = [line for line in lines if line.startswith("ring_") and "#" in line]
    assert len(chart) == 16
    assert all(line.count("#") == 3 for line in chart)
    assert all(len(line) <= 110 for line in lines)


def test_delays_of_almost_a_cycle_are_on_the_chart_too() -> None:
    config = ring(FiringConfig(mode="eeruf"))
    plan = plan_of(config)
    late = {name: replace(slot, delays_ns=(80 * MS, 90 * MS, 99 * MS)) for name, slot in plan.slots.items()}
    lines = timeline.text(config, replace(plan, slots=late))
    chart = [line for line in lines if line.startswith("ring_") and "#" in line]
    assert [line.count("#") for line in chart] == [3] * 16


def test_rangers_that_another_one_fires_are_called() -> None:
    config = ring(FiringConfig(mode="together", general_call=True))
    table = [line.split()[:4] for line in rows(config) if line.startswith("ring_") and " deg " in line]
    assert table[0][3] == "0.0"
    assert {row[3] for row in table[1:]} == {"called"}


def test_a_robot_of_none_but_free_runners_has_no_plan(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = DEFAULT_ROBOT.read_text()
    head, *sensors = text.split("[[sensor]]")
    free = [sensor for sensor in sensors if "a02yyuw" in sensor]
    firing = head[head.index("[firing]") : head.index("[[bus]]")]
    path = tmp_path / "robot.toml"
    path.write_text("[[sensor]]".join([head.replace(firing, ""), *free]))
    assert main(["schedule", str(path)]) == 0
    assert capsys.readouterr().out.startswith("no ranger fires when it is told to\n\nby themselves")


def test_a_plan_that_cannot_be_is_misuse_and_told_with_its_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "robot.toml"
    path.write_text(DEFAULT_ROBOT.read_text().replace("gap_ms = 70.0", "gap_ms = 10.0"))
    assert main(["schedule", str(path)]) == 2
    line = next(n for n, each in enumerate(path.read_text().splitlines(), 1) if "gap_ms" in each)
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith(f"{path}:{line}: firing.gap_ms: it takes ")
    assert "give as much at least" in err
