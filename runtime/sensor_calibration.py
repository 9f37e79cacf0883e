"""What a log tells of its rangers: their beams, noise, axes and sonar models, against a map."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from math import hypot, nan, radians

import numpy as np

from echogrid.mapping import wall_trials
from echogrid.mapping.sensor_calibration import Beam, Calibration, Estimate, calibrated
from echogrid.mapping.wall_trials import Ping, Trials
from echogrid.runtime import assembly, model_trial
from echogrid.runtime.config import Config
from echogrid.runtime.errors import UsageError
from echogrid.runtime.hardware_config import SensorConfig
from echogrid.runtime.model_trial import Beliefs, ModelTrial
from echogrid.runtime.recording import Recording
from echogrid.runtime.reference_map import LoggedPing, Reference

_MOST = 20_000
"""Pings from which a model is counted; of more it takes every so many."""
_CROOKED = radians(0.5)
"""What the log's own walls may add to the error of an axis."""
_WIDER = 1.5
"""Of the configured half angle: the model's cone where the beam is not known."""


@dataclass(frozen=True, slots=True)
class Kind:
    """Rangers that are alike in robot.toml: of one driver, half angle and reach."""

    name: str
    sensors: tuple[int, ...]
    """Which of the configuration's."""


@dataclass(frozen=True, slots=True)
class Result:
    """What was found of the rangers of one kind."""

    kind: Kind
    found: Calibration
    trial: ModelTrial | None
    """None: too little was seen to judge a model."""


def kinds(sensors: Sequence[SensorConfig]) -> list[Kind]:
    """Those that are alike together, in the order of their first."""

    def like(index: int) -> tuple[str, float, float, float]:
        sensor = sensors[index]
        return sensor.driver or "", sensor.half_angle_deg, sensor.min_m, sensor.max_m

    groups = [tuple(each) for _, each in groupby(sorted(range(len(sensors)), key=like), like)]
    return [Kind(sensors[each[0]].driver or "rangers", each) for each in sorted(groups)]


def results(
    recording: Recording, pings: Sequence[LoggedPing], reference: Reference, seed: int
) -> list[Result]:
    """What is found of each kind. Raises UsageError without a ping at a pose."""
    if not pings:
        raise UsageError(["no ping at any pose: there is nothing to calibrate by", *recording.faults.lines()])
    found = []
    for kind in kinds(recording.config.sensor):
        mine = [ping for ping in pings if ping.sensor in kind.sensors]
        if mine:
            half_angle = mine[0].ranger.half_angle
            told = calibrated(_trials(mine, reference), half_angle, np.random.default_rng(seed))
            told = _relative(told) if reference.own else _as_coarse(told, reference)
            found.append(Result(kind, told, _tried(recording.config, mine, reference, told)))
    return found


def _trials(pings: Sequence[LoggedPing], reference: Reference) -> Trials:
    told, views = [], []
    for ping in pings:
        reading = nan if ping.echo is None else ping.echo
        _, faces = reference.of(ping)
        for view in wall_trials.tried(faces, ping.ranger, ping.transducer, reading):
            told.append(Ping(ping.sensor, ping.reading.stamp_ns, ping.stretch, reading))
            views.append(view)
    return wall_trials.trials(told, views)


def _relative(found: Calibration) -> Calibration:
    """With biases against that of the most, and axes no surer than the log's own walls are straight: they
    stand where its readings put them."""
    turned = tuple(
        replace(each, yaw=replace(each.yaw, error=hypot(each.yaw.error, _CROOKED)))
        if isinstance(each.yaw, Estimate)
        else each
        for each in found.own
    )
    found = replace(found, own=turned)
    biases = [each.bias.value for each in found.own if isinstance(each.bias, Estimate)]
    middle = float(np.median(biases)) if biases else 0.0
    return _with_biases(found, lambda bias: replace(bias, value=bias.value - middle))


def _as_coarse(found: Calibration, reference: Reference) -> Calibration:
    """With biases no surer than the walls of the map are."""
    return _with_biases(found, lambda bias: replace(bias, error=hypot(bias.error, reference.off)))


def _with_biases(found: Calibration, change: Callable[[Estimate], Estimate]) -> Calibration:
    own = tuple(
        replace(each, bias=change(each.bias)) if isinstance(each.bias, Estimate) else each
        for each in found.own
    )
    return replace(found, own=own)


def _tried(
    config: Config, pings: Sequence[LoggedPing], reference: Reference, found: Calibration
) -> ModelTrial | None:
    beam, ranger = found.beam, pings[0].ranger
    half_angle = (
        beam.half_angle.value if isinstance(beam, Beam) else min(_WIDER * ranger.half_angle, radians(60.0))
    )
    beliefs = Beliefs(assembly.sonar_model(config), config.map.no_echo, half_angle)
    some = pings[:: len(pings) // _MOST + 1]
    return model_trial.tried(model_trial.halves(some, reference.maps, config.map.tolerance_m), beliefs)
