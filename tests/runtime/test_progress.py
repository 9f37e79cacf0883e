from echogrid.mapping.pose import Pose
from echogrid.runtime.modes.progress import Progress


def test_who_stays_where_he_is_for_too_long_does_not_get_on_and_that_is_told_once() -> None:
    progress = Progress(0.3, 1000)
    told = [progress.lacking(now_ns, Pose(0.001 * (now_ns % 200))) for now_ns in range(0, 2500, 100)]
    assert [now_ns * 100 for now_ns, lacks in enumerate(told) if lacks] == [1000, 2000]


def test_who_goes_on_is_never_told_so() -> None:
    progress = Progress(0.3, 1000)
    assert not any(progress.lacking(now_ns, Pose(0.0, 0.0004 * now_ns)) for now_ns in range(0, 9000, 100))


def test_what_was_before_a_rest_does_not_count() -> None:
    progress = Progress(0.3, 1000)
    assert not progress.lacking(0, Pose())
    progress.forget()
    assert not progress.lacking(5000, Pose())
    assert progress.lacking(6000, Pose())
