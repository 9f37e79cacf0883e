from hypothesis import given
from hypothesis import strategies as st

from echogrid.drivers.readings import Outcome
from echogrid.mapping.ledger import Ledger

outcomes = st.lists(st.sampled_from(Outcome))


@given(outcomes)
def test_what_was_produced_is_counted_by_outcome(produced: list[Outcome]) -> None:
    ledger = Ledger()
    for outcome in produced:
        ledger.produce(outcome)
    assert ledger.produced == len(produced)
    assert ledger.outcomes == {outcome.value: produced.count(outcome) for outcome in produced}


@given(st.integers(0, 5), st.lists(st.sampled_from(["late", "invalid"]), max_size=5), st.integers(0, 5))
def test_the_books_balance_when_every_reading_has_one_fate(
    fused: int, drops: list[str], waiting: int
) -> None:
    ledger = Ledger()
    for _ in range(fused + len(drops) + waiting):
        ledger.produce(Outcome.ECHO)
    ledger.fused = fused
    for reason in drops:
        ledger.drop(reason)
    assert ledger.balances(waiting)
    assert not ledger.balances(waiting + 1)


def test_a_lost_reading_is_noticed() -> None:
    ledger = Ledger()
    ledger.produce(Outcome.ECHO)
    assert not ledger.balances(0)


def test_two_ledgers_share_nothing() -> None:
    one, other = Ledger(), Ledger()
    one.drop("late")
    assert not other.dropped
