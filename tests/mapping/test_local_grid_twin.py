"""The local grid beside a twin that looks at every cell of every cone: both hold the same, to the bit."""

from math import radians, tau

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from echogrid.mapping.cone import cast
from echogrid.mapping.local_grid import LocalGrid
from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger
from echogrid.mapping.sonar_model import NoEcho
from echogrid.mapping.sounding import Sounding

from .strategies import poses

RESOLUTION, CELLS, TOLERANCE = 0.1, 60, 0.1
MS = 1_000_000
ASIDE = radians(15.0)

robots = poses(0.4)
echoes = st.none() | st.floats(0.1, 4.5)
seats = st.builds(
    Ranger,
    st.sampled_from(["left", "right"]),
    st.builds(Pose, st.floats(-0.2, 0.2), st.floats(-0.2, 0.2), st.floats(-3.2, 3.2)),
    st.floats(1e-3, 1.4),
    st.just(0.0),
    st.floats(0.5, 4.5),
    no_echo=st.none() | st.sampled_from(NoEcho),
)


class Plain(LocalGrid):
    """Fuses the whole cone, then gives back to the cells that answered from elsewhere what they were."""

    def fuse(self, transducer: Pose, ranger: Ranger, echo_distance: float | None, stamp_ns: int) -> None:
        cone = cast(self.geometry, Sounding(transducer, ranger, echo_distance, TOLERANCE))
        nearer = cone.cells[~cone.occupied]
        away = (self._axis.ravel()[nearer] - transducer.yaw + tau / 2.0) % tau - tau / 2.0
        held = nearer[(self.grid.log_odds.ravel()[nearer] > 0) & (np.abs(away) > ASIDE)]
        before, seen_ns = self.grid.log_odds.ravel()[held], self.seen_ns.ravel()[held]
        spoken = self.grid.fuse(cone)
        self.seen_ns.ravel()[spoken] = np.maximum(self.seen_ns.ravel()[spoken], stamp_ns)
        self.grid.log_odds.ravel()[held], self.seen_ns.ravel()[held] = before, seen_ns
        if echo_distance is not None:
            self._axis.ravel()[cone.cells[cone.occupied]] = transducer.yaw
            for x, y in self._walls.beyond(transducer, ranger, echo_distance, stamp_ns):
                self._expect(x, y, transducer.yaw, stamp_ns)


@settings(deadline=None)
@given(st.lists(st.tuples(robots, st.lists(st.tuples(seats, echoes), max_size=6)), max_size=6))
def test_what_is_fused_is_as_if_all_of_every_cone_were_looked_at(
    rounds: list[tuple[Pose, list[tuple[Ranger, float | None]]]],
) -> None:
    quick, plain = (made(RESOLUTION, CELLS, TOLERANCE, 15.0, NoEcho.WEAK) for made in (LocalGrid, Plain))
    for number, (robot, pings) in enumerate(rounds):
        for local in (quick, plain):
            local.centre(robot)
            local.fade(number * 300 * MS)
            for place, (ranger, echo) in enumerate(pings):
                local.fuse(robot.compose(ranger.mount), ranger, echo, (number * 300 + 7 * place) * MS)
        assert np.array_equal(quick.grid.log_odds, plain.grid.log_odds)
        assert np.array_equal(quick.seen_ns, plain.seen_ns)
