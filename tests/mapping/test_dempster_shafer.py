from itertools import permutations
from math import atanh, ceil, cos, exp, isfinite, log, radians, sin, tanh

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.bayes import BayesGrid
from echogrid.mapping.cone import Cone, Floats, belief
from echogrid.mapping.dempster_shafer import (
    FLOOR,
    DempsterShaferGrid,
    Masses,
    Rule,
    TotalConflict,
    combined,
    floored,
    simple_support,
)
from echogrid.mapping.grid import GridGeometry
from echogrid.mapping.himm import HimmGrid
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.sonar_model import Form, NoEcho, consistent, log_odds
from echogrid.mapping.sounding import Sounding

from .by_hand import Cell
from .strategies import poses, rangers

GEOMETRY = GridGeometry.covering(-2.0, -2.0, 2.0, 2.0, 0.2)
FIRST, SECOND, THIRD = (0.0, 0.825, 0.175), (0.5226666667, 0.0, 0.4773333333), (0.539, 0.0, 0.461)
THREE_STEPS = [(9.0, 0.0, 9.0), (8.5, 5.0, 8.7), (8.0, 10.0, 9.5)]
"""Feet and degrees: r, alpha and s of one cell."""

pings = st.tuples(poses(2.0), rangers(0.05), st.none() | st.floats(0.0, 4.0))
silences = st.sampled_from(NoEcho)


@st.composite
def masses(draw: st.DrawFn, most: float = 1.0) -> Masses:
    """Of one cell, committed up to `most`."""
    committed, part = draw(st.floats(0.0, most)), draw(st.floats(0.0, 1.0))
    return single(committed * part, committed * (1.0 - part), 1.0 - committed)


def single(occupied: float, empty: float, unsure: float) -> Masses:
    return Masses(np.array(occupied), np.array(empty), np.array(unsure))


def numbers(told: Masses) -> tuple[float, ...]:
    return tuple(float(each) for each in told)


def grid_of(no_echo: NoEcho = NoEcho.WEAK, rule: Rule | None = None) -> DempsterShaferGrid:
    return DempsterShaferGrid(GEOMETRY, Form.CONSISTENT, no_echo, rule or Rule())


# The rule


@given(masses(), masses(), st.sampled_from(TotalConflict))
def test_masses_stay_masses(one: Masses, other: Masses, policy: TotalConflict) -> None:
    found = combined(one, other, policy)
    assert sum(numbers(found.masses)) == approx(1.0, abs=1e-12)
    assert min(numbers(found.masses)) >= 0.0
    assert 0.0 <= float(found.conflict) <= 20.0


@given(masses(0.99), masses(0.99), masses(0.99))
def test_evidence_combines_in_any_order_and_so_does_its_conflict(
    one: Masses, two: Masses, three: Masses
) -> None:
    results = []
    for order in permutations((one, two, three)):
        state, conflict = order[0], 0.0
        for other in order[1:]:
            state, step, _ = combined(state, other)
            conflict += float(step)
        results.append((*numbers(state), conflict))
    for result in results:
        assert result == approx(results[0], abs=1e-9)


@given(masses())
def test_what_says_nothing_changes_nothing(told: Masses) -> None:
    found = combined(told, single(0.0, 0.0, 1.0))
    assert numbers(found.masses) == approx(numbers(told), abs=1e-12)
    assert float(found.conflict) == approx(0.0, abs=1e-12)


@given(masses(), st.floats(0.0, 0.9))
def test_the_floor_keeps_the_ratio_of_what_is_committed(told: Masses, floor: float) -> None:
    occupied, empty, unsure = numbers(floored(told, floor))
    assert occupied + empty + unsure == approx(1.0, abs=1e-12)
    assert unsure >= floor
    assert occupied * float(told.empty) == approx(empty * float(told.occupied), abs=1e-12)


@pytest.mark.parametrize(
    ("one", "other", "due", "conflict"),
    [
        ((0.4, 0.0, 0.6), (0.6, 0.0, 0.4), (0.76, 0.0, 0.24), 0.0),
        ((0.4, 0.0, 0.6), (0.0, 0.6, 0.4), (0.2105263, 0.4736842, 0.3157895), 0.2744368),
        (FIRST, SECOND, (0.1608064, 0.6923347, 0.1468589), 0.5642264),
        (FIRST, (0.0, 0.0, 1.0), FIRST, 0.0),
    ],
)
def test_dempster_s_rule_at_the_book_s_numbers(
    one: tuple[float, ...], other: tuple[float, ...], due: tuple[float, ...], conflict: float
) -> None:
    found = combined(single(*one), single(*other))
    assert numbers(found.masses) == approx(due, abs=1e-6)
    assert float(found.conflict) == approx(conflict, abs=1e-6)


@pytest.mark.parametrize("order", list(permutations((FIRST, SECOND, THIRD))))
def test_the_weight_of_conflict_adds_up_to_the_same_in_any_order(
    order: tuple[tuple[float, ...], ...],
) -> None:
    one, conflict, _ = combined(single(*order[0]), single(*order[1]))
    two, more, _ = combined(one, single(*order[2]))
    assert numbers(two) == approx((0.3828194, 0.5091740, 0.1080066), abs=1e-6)
    assert float(conflict + more) == approx(1.0313038, abs=1e-6)


@pytest.mark.parametrize(
    ("policy", "due"),
    [
        (TotalConflict.RESET, (0.0, 0.0, 1.0)),
        (TotalConflict.YAGER, (0.0, 0.0, 1.0)),
        (TotalConflict.KEEP, (1.0, 0.0, 0.0)),
    ],
)
def test_a_policy_decides_where_the_rule_has_no_answer(policy: TotalConflict, due: tuple[float, ...]) -> None:
    found = combined(single(1.0, 0.0, 0.0), single(0.0, 1.0, 0.0), policy)
    assert numbers(found.masses) == due
    assert (float(found.conflict), bool(found.total)) == (20.0, True)


def test_without_a_floor_twenty_sure_pings_can_never_be_answered_and_with_it_they_can() -> None:
    ping, against = single(0.9, 0.0, 0.1), single(0.0, 0.825, 0.175)
    bare = with_floor = single(0.0, 0.0, 1.0)
    for _ in range(20):
        bare, with_floor = combined(bare, ping).masses, floored(combined(with_floor, ping).masses)
    assert float(bare.unsure) == approx(1e-20)
    stuck, moved = combined(bare, against), combined(with_floor, against)
    assert numbers(stuck.masses) == approx((1.0, 0.0, 0.0), abs=1e-6)
    assert float(stuck.conflict) == approx(1.7429693, abs=1e-6)
    assert numbers(moved.masses) == approx((0.8955614, 0.0861619, 0.0182768), abs=1e-6)
    assert float(moved.conflict) == approx(1.6528675, abs=1e-6)


# The masses of a ping


@given(st.floats(0.0, 0.99), st.booleans())
def test_the_consistent_form_s_masses_are_the_book_s(strength: float, occupied: bool) -> None:
    p = consistent(np.array(strength), np.array(occupied))
    due = (0.98 * strength, 0.0) if occupied else (0.0, strength)
    assert numbers(simple_support(log_odds(p)))[:2] == approx(due, abs=1e-9)


@pytest.mark.parametrize(
    ("distance", "degrees", "at_echo", "due"),
    [(3.5, 0.0, False, FIRST), (6.0, 5.0, True, SECOND), (9.0, 0.0, True, THIRD)],
)
def test_equations_11_7_and_11_8_at_the_book_s_cells(
    distance: float, degrees: float, at_echo: bool, due: tuple[float, ...]
) -> None:
    b = belief(np.array(distance), np.array(radians(degrees)), 10.0, radians(15.0))
    found = simple_support(log_odds(consistent(b, np.array(at_echo))))
    assert numbers(found) == approx(due, abs=1e-6)


@given(st.floats(-800.0, 800.0))
def test_the_pignistic_probability_is_that_of_the_evidence(log_ratio: float) -> None:
    occupied, empty, unsure = numbers(simple_support(np.array(log_ratio)))
    assert occupied + empty + unsure == approx(1.0, abs=1e-12)
    assert occupied + unsure / 2.0 == approx(1.0 / (1.0 + exp(-min(max(log_ratio, -700), 700))), abs=1e-12)


# The grid


def by_hand(cell: Cell, no_echo: NoEcho, state: tuple[float, float, float]) -> tuple[float, float, float]:
    """m(Occ), m(Emp) and the sum of Con after a ping, as the book writes it."""
    ratio = cell.likelihood_ratio(Form.CONSISTENT, no_echo)
    if abs(ratio) <= 0.0005:
        return state
    o1, e1, conflict = state
    o2, e2 = max(tanh(ratio / 2), 0.0), max(-tanh(ratio / 2), 0.0)
    d1, d2 = 1.0 - o1 - e1, 1.0 - o2 - e2
    k = o1 * e2 + e1 * o2
    o, e = (o1 * o2 + o1 * d2 + d1 * o2) / (1 - k), (e1 * e2 + e1 * d2 + d1 * e2) / (1 - k)
    if 1.0 - o - e < FLOOR:
        o, e = o * (1.0 - FLOOR) / (o + e), e * (1.0 - FLOOR) / (o + e)
    return o, e, conflict + log(1.0 / (1.0 - k))


@settings(deadline=None)
@given(st.lists(pings, min_size=1, max_size=4), silences)
def test_an_update_is_that_of_the_equations_cell_by_cell(
    many: list[tuple[Pose, Ranger, float | None]], no_echo: NoEcho
) -> None:
    grid = grid_of(no_echo)
    for ping in many:
        grid.update(Sounding(*ping, 0.1))
    for row, y in enumerate(GEOMETRY.y_centres):
        for col, x in enumerate(GEOMETRY.x_centres):
            cells = [Cell(float(x), float(y), ping, GEOMETRY.resolution) for ping in many]
            ratios = [abs(cell.likelihood_ratio(Form.CONSISTENT, no_echo)) for cell in cells]
            if any(cell.on_a_border() for cell in cells) or any(abs(r - 0.0005) < 1e-9 for r in ratios):
                continue
            state = (0.0, 0.0, 0.0)
            for cell in cells:
                state = by_hand(cell, no_echo, state)
            found = grid.occupied[row, col], grid.empty[row, col], grid.conflict[row, col]
            assert found == approx(state, abs=2e-6)
            assert all(cell.region() == 3 for cell in cells) <= bool(grid.unknown()[row, col])


@settings(deadline=None)
@given(pings, silences)
def test_after_one_ping_it_believes_what_bayes_believes_and_knows_the_same_cells(
    ping: tuple[Pose, Ranger, float | None], no_echo: NoEcho
) -> None:
    grid, bayes = grid_of(no_echo), BayesGrid(GEOMETRY, 32.0, Form.CONSISTENT, no_echo)
    touched = grid.update(Sounding(*ping, 0.1)), bayes.update(Sounding(*ping, 0.1))
    assert touched[0] == touched[1]
    assert grid.occupancy() == approx(bayes.occupancy(), abs=0.02)
    quiet = np.abs(bayes.log_odds) < 3500
    assert grid.occupancy()[quiet] == approx(bayes.occupancy()[quiet], abs=2e-4)
    assert np.array_equal(grid.unknown(), bayes.unknown())


@settings(deadline=None)
@given(st.lists(pings, max_size=8), silences, st.floats(0.0, 0.5))
def test_belief_never_goes_above_plausibility_nor_conflict_down(many, no_echo: NoEcho, floor: float) -> None:
    grid = grid_of(no_echo, Rule(floor))
    before = grid.conflict.copy()
    for ping in many:
        grid.update(Sounding(*ping, 0.1))
        assert np.all(grid.conflict >= before)
        before = grid.conflict.copy()
    low, between, high = grid.belief(), grid.occupancy(), grid.plausibility()
    assert np.all((low >= 0.0) & (low <= between + 1e-6) & (between <= high + 1e-6) & (high <= 1.0))
    assert np.all(between[grid.unknown()] == 0.5)


@settings(deadline=None, max_examples=30)
@given(masses(1.0 - FLOOR), st.floats(0.002, 0.99), st.booleans())
def test_from_any_state_a_bounded_number_of_contrary_pings_leads_across_one_half(
    state: Masses, strength: float, towards_occupied: bool
) -> None:
    ping = (
        single(strength, 0.0, 1.0 - strength) if towards_occupied else single(0.0, strength, 1.0 - strength)
    )
    most = ceil(log(1.0 + 49.0 / strength) / -log(1.0 - strength)) + 1
    for _ in range(most):
        occupied, empty, unsure = floored(combined(state, ping).masses)
        state = Masses(*(np.float64(np.float32(each)) for each in (occupied, empty, unsure)))
    assert (state.occupied > state.empty) == towards_occupied


class Sure:
    """A model whose pings leave no doubt."""

    def believed(self, sounding: Sounding) -> Sounding:
        return sounding

    def echo(self, cone: Cone) -> Floats:
        return np.where(cone.occupied, 100.0, -100.0)

    def silence(self, cone: Cone) -> Floats:
        return np.full(len(cone.rows), -100.0)


@pytest.mark.parametrize(("policy", "due"), [("reset", 0.5), ("yager", 0.5), ("keep", 1.0)])
def test_total_conflicts_are_counted(policy: str, due: float) -> None:
    ranger = Ranger("sonar", Pose(), radians(5.0), 0.0, 4.0)
    grid = DempsterShaferGrid(GEOMETRY, Sure(), NoEcho.WEAK, Rule(0.0, TotalConflict(policy)))
    grid.update(Sounding(Pose(-1.9, 0.1), ranger, 2.0, 0.1))
    cell = GEOMETRY.cell(0.1, 0.1)
    assert (float(grid.occupancy()[cell]), grid.total_conflicts) == (1.0, 0)
    grid.update(Sounding(Pose(-1.9, 0.1), ranger, 3.0, 0.1))
    assert float(grid.occupancy()[cell]) == due
    assert grid.total_conflicts >= 1
    assert isfinite(float(grid.conflict[cell]))
    assert float(grid.conflict[cell]) == 20.0


def test_the_three_theories_at_the_book_s_cell_after_each_of_three_readings() -> None:
    """By way of whole grids; the seat of each ping is where the cell is at that r and alpha."""
    geometry = GridGeometry.covering(-12.0, -12.0, 12.0, 12.0, 0.5)
    x, y = 0.25, 0.25
    cell = geometry.cell(x, y)
    ranger = Ranger("sonar", Pose(), radians(15.0), 0.0, 10.0)
    printed = BayesGrid(geometry, 32.0, Form.PRINTED, NoEcho.IGNORE)
    fixed = BayesGrid(geometry, 32.0, Form.CONSISTENT, NoEcho.IGNORE)
    evidence = DempsterShaferGrid(geometry, Form.CONSISTENT, NoEcho.IGNORE)
    himm = HimmGrid(geometry)
    due = [(0.5390, 0.7695, 0.5390, 0.0, 0.0, 3)]
    due += [(0.4382, 0.8863, 0.7235, 0.0, 0.0, 3), (0.6820, 0.8186, 0.6574, 0.0914, 0.2143, 3)]
    for (r, alpha, s), expected in zip(THREE_STEPS, due, strict=True):
        yaw = 0.3
        towards = yaw + radians(alpha)
        seat = Pose(x - r * cos(towards), y - r * sin(towards), yaw)
        for theory in (printed, fixed, evidence, himm):
            theory.update(Sounding(seat, ranger, s, 0.5))
        found = [printed.occupancy()[cell], fixed.occupancy()[cell], evidence.occupied[cell]]
        found += [evidence.empty[cell], evidence.conflict[cell], himm.counts[cell]]
        assert found == approx(expected, abs=3e-4)
        assert found[2:] == approx(expected[2:], abs=5.1e-5)


def test_a_copy_goes_its_own_way() -> None:
    grid = grid_of()
    twin = grid.copy()
    twin.update(Sounding(Pose(), Ranger("sonar", Pose(), 0.3, 0.0, 4.0), 1.0, 0.1))
    assert not (grid.occupied.any() or grid.empty.any())
    assert grid.unknown().all()
    assert twin.empty.any()


@pytest.mark.parametrize("floor", [-0.1, 1.0, float("nan")])
def test_an_impossible_floor_is_refused(floor: float) -> None:
    with pytest.raises(ValueError, match="floor"):
        Rule(floor)


def test_bel_pl_and_betp_of_the_book_s_two_readings() -> None:
    grid = grid_of()
    for told in (FIRST, SECOND):
        ratio = 2.0 * atanh(told[0] - told[1])
        assert numbers(simple_support(np.array(ratio))) == approx(told, abs=1e-9)
    found = combined(single(*FIRST), single(*SECOND)).masses
    grid.occupied[3, 4], grid.empty[3, 4] = found.occupied, found.empty
    at = grid.belief()[3, 4], grid.plausibility()[3, 4], grid.occupancy()[3, 4]
    assert at == approx((0.1608064, 0.3076653, 0.2342358), abs=1e-6)
