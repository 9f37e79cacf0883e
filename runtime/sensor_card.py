"""The model card: what was found of each ranger, on how much data, and how sure it is."""

from collections.abc import Iterator, Sequence
from math import degrees, isnan

from echogrid.mapping.sensor_calibration import (
    BEARINGS,
    DISTANCES,
    Beam,
    Calibration,
    Found,
    Noise,
    Own,
    TooFew,
)
from echogrid.runtime.config import Config
from echogrid.runtime.hardware_config import SensorConfig
from echogrid.runtime.model_trial import ModelTrial
from echogrid.runtime.sensor_calibration import Result

_WIDTH = 20


def lines(config: Config, results: Sequence[Result], own_map: bool) -> Iterator[str]:
    """What a person is told."""
    for result in results:
        yield from _of_kind(config.sensor, result)
        yield ""
    yield (
        "judged by the log's own map: biases are against that of most rangers of a kind"
        if own_map
        else "judged by the map that was given"
    )


def _of_kind(sensors: Sequence[SensorConfig], result: Result) -> Iterator[str]:
    found = result.found
    names = ", ".join(sensors[index].name for index in result.kind.sensors)
    yield f"{result.kind.name}: {names}"
    yield _row("pings", f"{found.pings}, {100.0 * found.silent:.0f} % of them without an echo")
    yield from _beam(found, sensors[result.kind.sensors[0]].half_angle_deg)
    yield _row("range noise", _noise(found.noise))
    yield _row("false echoes", _told(found.false_echoes, 100.0, "%", ".1f"))
    yield _row("sonar model", _model(result.trial))
    yield f"  {'':12}{'pings':>7}{'silent':>8}  {'yaw off, deg':18}{'half angle, deg':18}{'bias, cm':18}"
    yield from (f"  {_sensor(sensors[own.sensor].name, own)}" for own in found.own)


def _beam(found: Calibration, configured_deg: float) -> Iterator[str]:
    beam = found.beam
    if isinstance(beam, TooFew):
        yield _row("walls answer", _short(beam))
        return
    at = ", ".join(
        f"{degrees(beam.profile.half_angle_at(distance)):.0f} at {distance:g} m"
        for distance in (0.5, 1.0, 2.0)
    )
    told = _told(beam.half_angle, degrees(1.0), "deg", ".1f")
    yield _row(
        "walls answer within", f"{told} at {beam.profile.middle:.1f} m ({at}); configured {configured_deg:g}"
    )
    yield _row("on the axis", f"{100.0 * beam.profile.top:.0f} % of walls answer")
    yield from _silence(beam)


def _silence(beam: Beam) -> Iterator[str]:
    """The parts of pings without an echo, where any are known."""
    known = [col for col in range(len(DISTANCES) - 1) if not all(map(isnan, beam.silence[:, col]))]
    heads = [f"{DISTANCES[col]:g} m" for col in known]
    yield _row(
        "without an echo, by",
        "bearing of the wall, and its distance from" + "".join(f"{each:>8}" for each in heads),
    )
    for row, shares in enumerate(beam.silence):
        cells = ["-" if isnan(shares[col]) else f"{100.0 * shares[col]:.0f} %" for col in known]
        bearing = f"{degrees(BEARINGS[row]):.0f} to {degrees(BEARINGS[row + 1]):.0f} deg"
        yield _row("", f"{bearing:42}" + "".join(f"{each:>8}" for each in cells))


def _noise(noise: Noise | TooFew) -> str:
    if isinstance(noise, TooFew):
        return _short(noise)
    near, growth = _told(noise.near, 1000.0, "mm", ".1f"), _told(noise.growth, 100.0, "% r", ".1f")
    return f"sigma = {near} + {growth}, by {noise.pairs} pairs of readings"


def _model(trial: ModelTrial | None) -> str:
    if trial is None:
        return "too little was seen in each half of the log to judge a model"
    skills = trial.skills
    return (
        f"held-out skill {skills.empirical:+.2f}, as configured {skills.configured:+.2f}, "
        f"with the half angle found {skills.found:+.2f} ({trial.cells} cells); factor {trial.factor:.2g}"
    )


def _sensor(name: str, own: Own) -> str:
    cells = (
        _plain(own.yaw, degrees(1.0), "+.1f"),
        _plain(own.half_angle, degrees(1.0), ".1f"),
        _plain(own.bias, 100.0, "+.1f"),
    )
    return (
        f"{name:12}{own.pings:7}{100.0 * own.silent:6.0f} %  "
        + "".join(f"{each:18}" for each in cells).rstrip()
    )


def _plain(found: Found, scale: float, form: str) -> str:
    if isinstance(found, TooFew):
        return f"- ({found.found} of {found.needed})"
    return f"{scale * found.value:{form}} +- {scale * found.error:.1f}"


def _told(found: Found, scale: float, unit: str, form: str) -> str:
    return _short(found) if isinstance(found, TooFew) else f"{_plain(found, scale, form)} {unit}"


def _short(short: TooFew) -> str:
    return f"not known: {short.found} {short.what}, {short.needed} are needed"


def _row(what: str, told: str) -> str:
    return f"  {what:{_WIDTH}} {told}"
