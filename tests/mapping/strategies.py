"""What hypothesis draws for more than one file: poses and rangers."""

from math import pi

from hypothesis import strategies as st

from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger

angles = st.floats(-20.0, 20.0)


def poses(reach: float = 5.0) -> st.SearchStrategy[Pose]:
    """Anywhere within a square; the yaw may be several turns."""
    return st.builds(Pose, st.floats(-reach, reach), st.floats(-reach, reach), angles)


def rangers(narrowest: float = 1e-3) -> st.SearchStrategy[Ranger]:
    """In the robot's middle, from a needle to nearly half a circle."""
    return st.builds(
        Ranger,
        st.just("sonar"),
        st.just(Pose()),
        st.floats(narrowest, pi / 2.0 - 1e-3),
        st.just(0.0),
        st.floats(0.1, 6.0),
    )
