from math import nan

from hypothesis import given
from hypothesis import strategies as st

from echogrid.drivers.readings import Outcome, RangeReading
from echogrid.mapping.placed_ping import PlacedPing
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.verification import AGREEMENT, OLDEST_NS, Believer, Verifier, heard_at

MS = 1_000_000
RANGER = Ranger("front", Pose(), 0.2, 0.1, 5.0)
LEFT = Ranger("left", Pose(), 0.2, 0.1, 5.0)


def ping(stamp_ns: int, outcome: Outcome, distance: float = nan, ranger: Ranger = RANGER) -> PlacedPing:
    return PlacedPing(RangeReading(stamp_ns, 0, ranger.name, outcome, distance), ranger, Pose())


def echo(number: int, distance: float, ranger: Ranger = RANGER, x: float = 0.0) -> PlacedPing:
    reading = RangeReading(number * 100 * MS, 0, ranger.name, Outcome.ECHO, distance)
    return PlacedPing(reading, ranger, Pose(x))


def verified(pings: list[PlacedPing], verifier: Verifier | Believer | None = None) -> list[PlacedPing]:
    verifier = verifier or Verifier()
    return [each for one in pings for each in verifier.take(one).verified]


@st.composite
def sequences(draw: st.DrawFn) -> list[PlacedPing]:
    """Of two sensors, in the order of stamps."""
    gaps = draw(st.lists(st.integers(1, 400), max_size=20))
    outcome = st.sampled_from(list(Outcome))
    stamp_ns, pings = 0, []
    for gap in gaps:
        stamp_ns += gap * MS
        kind, ranger = draw(outcome), draw(st.sampled_from([RANGER, LEFT]))
        distance = draw(st.floats(0.1, 2.0)) if kind is Outcome.ECHO else nan
        pings.append(ping(stamp_ns, kind, distance, ranger))
    return pings


@given(sequences())
def test_every_ping_is_verified_or_refused_once_or_waits(pings: list[PlacedPing]) -> None:
    verifier = Verifier()
    fates: list[PlacedPing] = []
    for number, each in enumerate(pings, 1):
        verdict = verifier.take(each)
        fates += [*verdict.verified, *verdict.refused]
        assert len(fates) + verifier.waiting == number
    fates += verifier.finish()
    assert verifier.waiting == 0
    assert sorted(map(id, fates)) == sorted(map(id, pings))


@given(sequences())
def test_the_sensors_do_not_know_of_each_other(pings: list[PlacedPing]) -> None:
    together = verified(pings)
    for ranger in (RANGER, LEFT):
        alone = verified([each for each in pings if each.ranger is ranger])
        assert [each for each in together if each.ranger is ranger] == alone


@given(sequences())
def test_silence_and_faults_pass_at_once(pings: list[PlacedPing]) -> None:
    verifier = Verifier()
    for each in pings:
        verdict = verifier.take(each)
        if heard_at(each) is None:
            assert verdict.verified == (each,)


@given(st.lists(st.floats(0.2, 5.0), min_size=1, max_size=20))
def test_an_echo_is_verified_if_and_only_if_a_neighbour_agrees(distances: list[float]) -> None:
    pings = [echo(number, distance) for number, distance in enumerate(distances)]
    passed = set(map(id, verified(pings)))
    for number, each in enumerate(pings):
        neighbours = distances[max(number - 1, 0) : number] + distances[number + 1 : number + 2]
        agrees = any(abs(distances[number] - other) <= AGREEMENT for other in neighbours)
        assert (id(each) in passed) == agrees


@given(sequences())
def test_they_are_verified_in_the_order_of_their_stamps(pings: list[PlacedPing]) -> None:
    stamps = [each.reading.stamp_ns for each in verified([each for each in pings if each.ranger is LEFT])]
    assert stamps == sorted(stamps)


def test_a_new_obstacle_is_believed_one_ping_later() -> None:
    verifier = Verifier()
    seen = [verifier.take(echo(number, r)).verified for number, r in enumerate((3.0, 3.0, 1.0, 1.02))]
    assert [[heard_at(each) for each in passed] for passed in seen] == [[], [3.0, 3.0], [], [1.0, 1.02]]


def test_a_false_reading_alone_takes_no_true_one_with_it() -> None:
    passed = verified([echo(number, r) for number, r in enumerate((3.0, 3.0, 1.0, 3.0, 3.0))])
    assert [heard_at(each) for each in passed] == [3.0, 3.0, 3.0, 3.0]


def test_the_way_of_the_transducer_is_allowed_for() -> None:
    assert verified([echo(0, 2.0), echo(1, 1.75, x=0.2)])
    assert not verified([echo(0, 2.0), echo(1, 1.75, x=0.1)])


def test_readings_far_apart_in_time_are_not_compared() -> None:
    assert verified([ping(0, Outcome.ECHO, 1.0), ping(OLDEST_NS, Outcome.ECHO, 1.0)])
    assert not verified([ping(0, Outcome.ECHO, 1.0), ping(OLDEST_NS + 1, Outcome.ECHO, 1.0)])


def test_one_that_tells_something_once_a_second_is_verified_even_if_two_are_lost() -> None:
    pings = [ping(second * 1000 * MS, Outcome.ECHO, 1.0) for second in (0, 1, 3, 6)]
    assert verified(pings) == pings


def test_silence_between_two_echoes_parts_them() -> None:
    passed = verified([echo(0, 1.0), ping(100 * MS, Outcome.NO_ECHO), echo(2, 1.0)])
    assert [each.reading.outcome for each in passed] == [Outcome.NO_ECHO]


def test_what_is_too_close_agrees_with_what_is_just_not() -> None:
    assert len(verified([ping(0, Outcome.TOO_CLOSE), echo(1, 0.15)])) == 2
    assert not verified([ping(0, Outcome.TOO_CLOSE), echo(1, 0.3)])


@given(sequences())
def test_a_believer_verifies_all(pings: list[PlacedPing]) -> None:
    believer = Believer()
    assert verified(pings, believer) == pings
    assert (believer.waiting, believer.finish()) == (0, ())
