"""Results are kept, taken up again and told; failures are driven again."""

import json
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from echogrid.runtime.command_line import main
from echogrid.runtime.errors import UsageError
from echogrid.runtime.trials import campaign
from echogrid.runtime.trials.job import Job
from echogrid.runtime.trials.results import Line, Results
from echogrid.runtime.trials.table import Tally, _most, tables
from echogrid.runtime.trials.verdict import Bump, Verdict

JOB = Job("room", 1, "blind")
VERDICT = Verdict(
    outcome="reached",
    time_s=20.0,
    travelled=10.0,
    shortest=8.0,
    time_ratio=1.25,
    goal_error=0.35,
    least_clearance=0.1,
    low_clearance=0.12,
    near_misses=1,
    reversals=0,
    latency_s=(0.04, 0.07),
    pings=2000,
    digest="00ff",
    bumps=(Bump(3.0, "wall", 0.4, "collision"), Bump(5.0, "person", 0.0, "standing")),
)
LINE = Line(JOB, VERDICT, 0.5)


@given(st.sampled_from(["reached", "stuck", "late"]), st.floats(0.01, 100.0), st.floats(0.01, 100.0))
def test_spl_is_a_part_and_0_without_success(outcome, travelled, shortest):
    spl = replace(VERDICT, outcome=outcome, travelled=travelled, shortest=shortest).spl
    assert 0.0 <= spl <= 1.0
    assert (spl > 0.0) == (outcome == "reached")


def test_spl_is_the_shortest_way_over_the_way_that_was_driven():
    assert VERDICT.spl == pytest.approx(0.8)


def test_a_line_is_read_as_it_was_written():
    assert Line.of(json.loads(LINE.text())) == LINE


def test_results_are_there_again(tmp_path):
    path = tmp_path / "some/results.jsonl"
    Results(path).add(LINE)
    again = Results(path)
    assert JOB in again
    assert again[JOB] == LINE
    assert replace(JOB, seed=2) not in again
    assert replace(JOB, fault="dead") not in again


def test_a_line_that_was_cut_off_is_done_again(tmp_path):
    path = tmp_path / "results.jsonl"
    Results(path).add(LINE)
    other = replace(LINE, job=replace(JOB, seed=2))
    path.write_text(path.read_text() + other.text()[:40])
    results = Results(path)
    assert other.job not in results
    results.add(other)
    assert Results(path)[other.job] == other
    assert Results(path)[JOB] == LINE


def test_another_file_is_not_taken_for_results(tmp_path):
    path = tmp_path / "notes.txt"
    path.write_text("not a result\n")
    with pytest.raises(UsageError, match=r"notes.txt:1: no result of a trial"):
        Results(path)
    assert path.read_text() == "not a result\n"


def test_what_is_done_is_not_done_again(tmp_path, monkeypatch):
    done = []

    def drive(job, failures):
        done.append(job)
        return replace(LINE, job=job)

    monkeypatch.setattr(campaign, "drive", drive)
    plan = campaign.Plan(["a", "b"], ["blind"], range(2))
    jobs = list(plan.jobs())
    path = tmp_path / "results.jsonl"
    campaign.run(jobs[:3], Results(path), processes=1)
    campaign.run(jobs, Results(path), processes=1)
    assert done == jobs
    assert len(path.read_text().splitlines()) == 4


@pytest.mark.parametrize(("seen", "most"), [(0, 3.0), (1, 4.744), (2, 6.296), (5, 10.513), (20, 29.062)])
def test_the_bound_is_that_of_poisson(seen, most):
    assert _most(seen) == pytest.approx(most, rel=0.01)


def test_no_collision_in_a_kilometre_is_fewer_than_three():
    spotless = replace(LINE, verdict=replace(VERDICT, bumps=(), travelled=1000.0))
    assert Tally([spotless]).bound() == pytest.approx(3.0)


def test_the_table_has_a_row_for_each_world_and_their_sum():
    other = replace(LINE, job=replace(JOB, world="hall"), verdict=replace(VERDICT, outcome="stuck", bumps=()))
    rows = [row for row in tables([LINE, other]) if row.startswith("|")]
    heads = [row.split("|")[1].strip() for row in rows]
    assert heads == ["blind", "---", "room", "hall", "**all**", "all worlds", "---", "blind"]
    cells = [cell.strip() for cell in rows[4].split("|")]
    assert cells[2:5] == ["2", "0.020", "50.0 (236.4)"]
    assert "50 % (0 %)" in cells


def test_a_failure_is_driven_again_to_the_same_bits(tmp_path, capsys):
    arguments = ["trial", "--worlds", "traps", "--pilots", "blind", "--seeds", "1", "--processes", "1"]
    assert main([*arguments, "--failures", str(tmp_path)]) == 0
    assert "**all**" in capsys.readouterr().out
    (log,) = tmp_path.iterdir()
    assert main(["trial", "--replay", str(log)]) == 0
    assert "the same to the bit" in capsys.readouterr().out
    head, *rows = log.read_text().splitlines()
    spoilt = json.loads(head)
    spoilt["verdict"]["digest"] = "0" * 32
    row = json.loads(rows[100])
    row[1] += 1e-9
    rows[100] = json.dumps(row)
    log.write_text("\n".join([json.dumps(spoilt), *rows]) + "\n")
    assert main(["trial", "--replay", str(log)]) == 1
    assert f"another drive from {row[0]:.2f} s on" in capsys.readouterr().out


def test_what_is_no_log_is_refused(tmp_path, capsys):
    path = tmp_path / "log.jsonl"
    path.write_text("{}\n")
    assert main(["trial", "--replay", str(path)]) == 2
    assert "no log of a trial" in capsys.readouterr().err


def test_processes_give_the_same_as_one(tmp_path):
    jobs = list(campaign.Plan(["clutter"], ["blind"], range(2)).jobs())
    alone, together = Results(), Results()
    campaign.run(jobs, alone, processes=1)
    campaign.run(jobs, together, processes=2)
    assert [alone[job].verdict for job in jobs] == [together[job].verdict for job in jobs]


@pytest.mark.parametrize("option", [("--worlds", "attic"), ("--pilots", "pigeon"), ("--rig", "ring-3")])
def test_names_that_are_not_are_misuse(capsys, option):
    assert main(["trial", *option]) == 2
    assert option[1] in capsys.readouterr().err
