"""Pictures of what steering would decide on each map of a comparison, where that differs most."""

from collections.abc import Iterator
from math import degrees

from echogrid.mapping.pose import wrap_angle
from echogrid.mapping.virtual_sensor import Sector, SectorState
from echogrid.runtime.comparison_steering import AHEAD_M, Outcome, Scene, Steered
from echogrid.runtime.map_picture import PATH, UNKNOWN
from echogrid.runtime.picture_sheet import Gallery, Picture
from echogrid.runtime.polar_picture import THRESHOLD
from echogrid.runtime.steering_picture import panel
from echogrid.runtime.steering_window import BLOCKED, CHOSEN, GOAL, MASKED, NEAREST, OPEN

_ABREAST = 5
_NOSE = "straight ahead"
_KEY = (
    (PATH, "robot"),
    (GOAL, "goal"),
    (CHOSEN, "heading"),
    ((0, 0, 0), "obstacle"),
    (UNKNOWN, "unknown"),
    (MASKED, "out of reach"),
    (OPEN, "clear"),
    (BLOCKED, "blocked"),
    (NEAREST, "a sector's nearest obstacle"),
    (THRESHOLD, "thresholds"),
)


def scenes(steered: Steered) -> Iterator[Gallery]:
    """A gallery for each of the places: the windows, the histograms beneath."""
    for number, scene in enumerate(steered.scenes, 1):
        pose, goal = scene.place.pose, scene.place.goal
        yield Gallery(
            f"steering by each map, {number}: at {pose.x:.1f}, {pose.y:.1f} m",
            (
                f"VFH+ at {scene.place.speed:.2f} m/s. The goal is where the robot of the log was "
                f"{AHEAD_M:g} m of its way later: {goal.distance:.2f} m from here, "
                f"{_aside(goal.bearing - pose.yaw, _NOSE)}.",
                "Above, north up, the map as steering reads it, in a ring of the virtual sensor's sectors; "
                "beneath, the polar histogram, straight ahead in its middle.",
            ),
            _KEY,
            tuple(_pictures(scene)),
            _ABREAST,
        )


def _pictures(scene: Scene) -> Iterator[Picture]:
    for name, choice in scene.choices.items():
        told = f"{_told(scene, name)} {_sensed(choice.sectors)}"
        yield Picture(name, told, panel(choice.view, choice.decision, choice.sectors))


def _told(scene: Scene, name: str) -> str:
    """What is decided, and what becomes of it."""
    outcome, why = scene.outcomes[name], scene.choices[name].decision.why.value
    if outcome.heading is None:
        return f"{why}: it stops."
    off = _aside(outcome.heading - scene.place.goal.bearing, "the goal")
    return f"{why}, {off}; {_free(outcome, scene.choices[name].view.window.horizon)}."


def _free(outcome: Outcome, horizon: float) -> str:
    ways = (outcome.free, "in truth"), (outcome.promised, "by the map")
    told = [
        f"{'at least ' if way >= horizon else ''}{way:.2f} m free {whose}"
        for way, whose in ways
        if way is not None
    ]
    return ", ".join(told)


def _aside(angle: float, of: str) -> str:
    degrees_left = round(degrees(wrap_angle(angle)))
    if degrees_left == 0:
        return f"in line with {of}"
    return f"{abs(degrees_left)} deg {'left' if degrees_left > 0 else 'right'} of {of}"


def _sensed(sectors: tuple[Sector, ...]) -> str:
    """What the virtual sensor says."""
    clear = sum(sector.state is SectorState.CLEAR for sector in sectors)
    nearest = min(sectors, key=lambda sector: sector.nearest)
    counted = f"Sectors: {clear} of {len(sectors)} clear"
    if nearest.state is not SectorState.BLOCKED:
        return f"{counted}."
    return f"{counted}, nearest obstacle {nearest.nearest:.2f} m, {_aside(nearest.bearing, _NOSE)}."
