from dataclasses import replace

import pytest

from echogrid.mapping.cone import cast
from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.sonar_model import MAX_OCCUPIED, Form, NoEcho
from echogrid.mapping.sounding import Sounding
from echogrid.runtime.contenders import by_model, contenders, himm
from echogrid.runtime.ring_recording import RingPing
from echogrid.runtime.sensitivity import Sway, scaled_beam, scaled_tolerance, sways, turned

PING = RingPing(Sounding(Pose(), Ranger("sonar", Pose(), 0.2, 0.1, 5.0), 2.0, 0.12), 0.4)
GRID = GridGeometry.covering(-3.0, -3.0, 3.0, 3.0, 0.1)
CONSISTENT = next(each for each in contenders() if each.name.endswith("consistent, no echo: ignore"))


def test_a_wider_beam_is_all_that_is_changed() -> None:
    wider = scaled_beam(1.25, PING)
    assert wider.ranger.half_angle == pytest.approx(0.25)
    assert replace(wider, ranger=PING.sounding.ranger) == PING.sounding


def test_a_thicker_band_is_all_that_is_changed() -> None:
    thicker = scaled_tolerance(0.75, PING)
    assert thicker.tolerance == pytest.approx(0.09)
    assert replace(thicker, tolerance=0.12) == PING.sounding


def test_every_parameter_is_turned_both_ways_under_a_name_of_its_own() -> None:
    variants = turned(CONSISTENT)
    assert list(variants) == ["beta", "tolerance", "Max_occ"]
    names = [variant.name for pair in variants.values() for variant in pair]
    assert len(set(names)) == 6
    assert CONSISTENT.name not in names


@pytest.mark.parametrize("times", [0.75, 1.0])
def test_turning_max_occ_is_turning_it_in_the_equation(times: float) -> None:
    make = by_model("Bayes", "bayes", Form.PRINTED, NoEcho.IGNORE).numbers["Max_occ"](times)
    theory = make("museum", GRID)
    theory.update(PING.sounding)
    cone = cast(GRID, PING.sounding)
    due = cone.belief[cone.occupied] * MAX_OCCUPIED * times
    rows, cols = cone.rows[cone.occupied], cone.cols[cone.occupied]
    assert theory.occupancy()[rows, cols] == pytest.approx(due.clip(0.01, 0.99), abs=1e-3)
    empty = cone.rows[~cone.occupied], cone.cols[~cone.occupied]
    assert theory.occupancy()[empty] == pytest.approx(
        (1.0 - cone.belief[~cone.occupied]).clip(0.01), abs=1e-3
    )


@pytest.mark.parametrize(("parameter", "times", "due"), [("I+", 1.25, 3.75 / 15), ("I-", 0.75, 2.25 / 15)])
def test_the_steps_of_himm_are_turned_by_a_quarter(parameter: str, times: float, due: float) -> None:
    theory = himm("HIMM", NoEcho.IGNORE).numbers[parameter](times)("museum", GRID)
    theory.update(PING.sounding)
    at = GRID.cell(2.0, 0.0)
    if parameter == "I-":
        theory.update(replace(PING.sounding, echo=2.5))
    assert theory.occupancy()[at] == pytest.approx(due)


def test_the_largest_change_is_that_of_either_direction() -> None:
    assert Sway("theory", "beta", (-0.03, 0.01)).largest == 0.03


def test_a_theory_that_names_no_numbers_is_left_alone() -> None:
    assert sways([], 1, [replace(CONSISTENT, numbers=None)], 1) == []


def test_a_lap_tells_how_much_f1_depends_on_each() -> None:
    found = sways(["foyer"], 1, [replace(CONSISTENT, numbers={})], 2)
    assert [sway.parameter for sway in found] == ["beta", "tolerance"]
    for sway in found:
        assert 0.0 < sway.largest < 0.3
        assert sway.worst_world == pytest.approx(sway.largest)
