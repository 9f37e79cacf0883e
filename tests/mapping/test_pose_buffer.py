from math import hypot, pi, radians

from hypothesis import given
from hypothesis import strategies as st
from pytest import approx

from echogrid.mapping.pose import Pose
from echogrid.mapping.pose_buffer import PoseBuffer, PoseMiss

MS = 1_000_000
SECOND = 1000 * MS


def buffer(*stamps_ms: int, keep_ns: int | None = None) -> PoseBuffer:
    """Poses whose x is the time in seconds."""
    filled = PoseBuffer(keep_ns)
    for stamp in stamps_ms:
        filled.add(stamp * MS, Pose(x=stamp / 1000.0))
    return filled


@given(
    st.lists(st.integers(1, 499), min_size=1, max_size=40), st.floats(0.0, 1.0), st.sampled_from([None, 0])
)
def test_a_steady_motion_is_interpolated_at_any_moment(
    gaps_ms: list[int], place: float, keep_ns: int | None
) -> None:
    stamps = [sum(gaps_ms[:n]) for n in range(len(gaps_ms) + 1)]
    at_ns = round(place * stamps[-1] * MS)
    pose = buffer(*stamps, keep_ns=keep_ns).at(at_ns)
    assert isinstance(pose, Pose)
    assert pose.x == approx(at_ns * 1e-9, abs=1e-9)


def test_a_buffer_without_poses_waits() -> None:
    assert PoseBuffer().at(0) is PoseMiss.NOT_YET
    assert PoseBuffer().newest is None


def test_a_moment_after_the_last_pose_waits() -> None:
    assert buffer(0, 100).at(100 * MS + 1) is PoseMiss.NOT_YET


def test_a_moment_before_the_first_pose_has_none() -> None:
    assert buffer(100, 200).at(100 * MS - 1) is PoseMiss.BEFORE


def test_nobody_knows_what_happened_in_a_gap() -> None:
    assert buffer(0, 501).at(250 * MS) is PoseMiss.GAP


def test_the_widest_gap_is_none() -> None:
    assert buffer(0, 500).at(250 * MS) == Pose(x=0.25)


def test_the_poses_on_both_sides_of_a_gap_are_known() -> None:
    filled = buffer(0, 501)
    assert (filled.at(0), filled.at(501 * MS)) == (Pose(), Pose(x=0.501))


@given(st.lists(st.integers(0, 1000)))
def test_only_later_poses_are_taken(stamps: list[int]) -> None:
    filled, newest = PoseBuffer(), -1
    for stamp in stamps:
        assert filled.add(stamp, Pose(x=float(stamp))) is (stamp > newest)
        newest = max(newest, stamp)
        assert filled.newest == (newest, Pose(x=float(newest)))


@given(st.integers(256, 1500), st.integers(1, 400), st.integers(1, 20_000))
def test_it_reaches_back_as_far_as_promised(count: int, step_ms: int, keep_ms: int) -> None:
    filled = PoseBuffer(keep_ms * MS)
    for n in range(count):
        filled.add(n * step_ms * MS, Pose(x=float(n)))
    last_ms = (count - 1) * step_ms
    for back_ms in (0, keep_ms // 2, keep_ms):
        at_ms = max(last_ms - back_ms, 0)
        pose = filled.at(at_ms * MS)
        assert isinstance(pose, Pose)
        assert pose.x == approx(at_ms / step_ms)


def test_it_forgets() -> None:
    filled = buffer(*range(0, 20_000, 10), keep_ns=SECOND)
    assert filled.at(10_000 * MS) is PoseMiss.BEFORE


def test_a_buffer_for_ever_forgets_nothing() -> None:
    assert buffer(*range(0, 20_000, 10)).at(0) == Pose()


def test_a_pose_100_ms_old_misplaces_an_echo_at_4_m_by_half_a_metre() -> None:
    speed, rate, reach, late_s = 0.5, radians(60.0), 4.0, 0.1
    assert speed * late_s + rate * late_s * reach == approx(0.4688790, abs=1e-6)
    filled = PoseBuffer(None)
    filled.add(0, Pose())
    filled.add(200 * MS, Pose(x=speed * 0.2, yaw=rate * 0.2))
    fresh, stale = filled.at(200 * MS), filled.at(100 * MS)
    assert isinstance(fresh, Pose)
    assert isinstance(stale, Pose)
    worst = 0.0
    for step in range(360):
        bearing = -pi + radians(step)
        target = Pose(yaw=bearing).compose(Pose(x=reach))
        true, wrong = fresh.compose(target), stale.compose(target)
        worst = max(worst, hypot(true.x - wrong.x, true.y - wrong.y))
    assert worst == approx(0.469, abs=5e-4)
