"""The theories that `echogrid compare` sets beside each other, each as one that is judged."""

from collections.abc import Mapping
from dataclasses import replace

from echogrid.mapping.sonar_model import Form, NoEcho
from echogrid.runtime.contenders import by_model, by_speed, calibrated, counting, himm, range_layer
from echogrid.runtime.map_suite import Contender

OCCUPIED = 0.5
"""What is likelier is called occupied, whatever the theory."""
WHAT_IT_IS: Mapping[str, str] = {
    "bayes-printed": "Bayes with the sonar model as the book prints it (11.1, 11.2)",
    "bayes": "Bayes with the consistent model: the pignistic probability of Dempster-Shafer's masses",
    "bayes-by-speed": "bayes, with a cone that narrows to a third as the robot gets faster",
    "dempster-shafer": "Dempster's rule (11.9); the picture is BetP",
    "himm": "HIMM: counts on the axis (11.11); the picture is C/15",
    "himm-growth": "himm with the growth rate operator",
    "counting": "the reflection map: hits over hits and misses",
    "range-layer": "the model of nav2's range layer, with its defaults",
    "calibrated": "calibrated evidence, the long-term map's default",
}
"""By name."""
MATCHED = "bayes", "dempster-shafer"
"""The pair that believes the same of each single ping: what differs is the way of combining alone."""


def contenders(names: tuple[str, ...], no_echo: NoEcho, fastest: float) -> tuple[Contender, ...]:
    """Those of the names, in the order of the report. `fastest` (m/s) is at what the cone is narrowest."""
    steady = by_model("bayes", "bayes", Form.CONSISTENT, no_echo)
    everyone = (
        by_model("bayes-printed", "bayes", Form.PRINTED, no_echo),
        steady,
        replace(by_speed(steady, fastest), name="bayes-by-speed"),
        by_model("dempster-shafer", "dempster-shafer", Form.CONSISTENT, no_echo),
        himm("himm", no_echo),
        himm("himm-growth", no_echo, growth=True),
        counting("counting"),
        range_layer("range-layer"),
        calibrated("calibrated", OCCUPIED),
    )
    return tuple(each for each in everyone if each.name in names)
