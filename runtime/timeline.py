"""A firing plan as text: its groups, its rangers, and when each of them listens."""

from collections.abc import Iterator, Sequence
from math import degrees

from echogrid.drivers.role import Call
from echogrid.drivers.sound import speed_of_sound
from echogrid.runtime.config import Config
from echogrid.runtime.firing import Plan
from echogrid.runtime.firing_times import worst_gap_ns
from echogrid.runtime.schedule import Window, by_themselves, pings_per_s, windows

_COLUMNS = 80
"""For the time."""
_WIDTHS_NS = [step * 10**power for power in range(5, 10) for step in (1, 2, 5)]
"""Of a column: from 0.1 ms on."""
_TICK = 10
"""Columns from a mark of the ruler to the next."""
_FIRES, _LISTENS, _IDLE, _CYCLE = "#", "=", ".", "|"


def text(config: Config, plan: Plan) -> Iterator[str]:
    """Line by line."""
    others = by_themselves(config, plan)
    if plan.pingers:
        yield from _summary(config, plan)
        yield ""
        yield from _table(plan, list(windows(config, plan)))
        yield ""
        yield from _chart(plan, speed_of_sound(config.robot.air_temperature_c))
    else:
        yield "no ranger fires when it is told to"
    if others:
        yield ""
        yield f"by themselves, at no known time: {', '.join(others)}"


def _summary(config: Config, plan: Plan) -> Iterator[str]:
    count, groups = len(plan.pingers), len(plan.volleys)
    cycle_ms = plan.period_ns * 1e-6
    checked = (
        "must agree with the one before or after" if config.firing.verifies else "are believed as they are"
    )
    yield f"{config.robot.name}: {_plural(count, 'ranger')} in {_plural(groups, 'group')}"
    yield f'mode "{config.firing.mode}": readings {checked}'
    rates = f"{1e3 / cycle_ms:.1f} a second, {pings_per_s(plan):.1f} pings a second"
    yield f"a cycle of {cycle_ms:.1f} ms: {rates}"
    for number, volley in enumerate(plan.volleys, 1):
        times = f"at {volley.offset_ns * 1e-6:.1f} ms, for {volley.gap_ns * 1e-6:.1f} ms"
        yield f"group {number} {times}: {', '.join(volley.members)}"


def _table(plan: Plan, heard: Sequence[Window]) -> Iterator[str]:
    rows = [("ranger", "bearing", "turn at", "delays, in rotation", "worst gap", "may hear")]
    for volley in plan.volleys:
        for name in volley.members:
            pinger = next(pinger for pinger in plan.pingers if pinger.name == name)
            slot = plan.slots[name]
            delays = " ".join(f"{delay_ns * 1e-6:.1f}" for delay_ns in slot.delays_ns)
            call = plan.calls.get(name, Call.ITSELF)
            rows.append(
                (
                    name,
                    f"{degrees(pinger.bearing):.0f} deg",
                    "called" if call is Call.CALLED else f"{slot.offset_ns * 1e-6:.1f} ms",
                    f"{delays} ms" if len(slot.delays_ns) > 1 else "-",
                    f"{worst_gap_ns(slot) * 1e-6:.1f} ms",
                    _hears([window for window in heard if window.listener == name]),
                )
            )
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for name, *others, last in rows:
        cells = (other.rjust(width) for other, width in zip(others, widths[1:], strict=False))
        yield "  ".join((name.ljust(widths[0]), *cells, last))


def _hears(heard: Sequence[Window]) -> str:
    """Of how many, and between which distances it would seem to be."""
    bands = [band for window in heard for band in window.bands if band]
    if not bands:
        return "none"
    nearest, farthest = min(near for near, _ in bands), max(far for _, far in bands)
    return f"{_plural(len(heard), 'other')}, as if from {nearest:.2f} to {farthest:.2f} m"


def _chart(plan: Plan, speed: float) -> Iterator[str]:
    """A row for each ranger, over all cycles of the rotation."""
    cycles = max(len(slot.delays_ns) for slot in plan.slots.values())
    total_ns = cycles * plan.period_ns
    column_ns = next(width for width in _WIDTHS_NS if width * _COLUMNS >= total_ns)
    columns = -(-total_ns // column_ns)
    margin = max(len(pinger.name) for pinger in plan.pingers)
    ticks = (f"{number * column_ns * 1e-6:g}".ljust(_TICK) for number in range(0, columns, _TICK))
    yield f"{'ms'.rjust(margin)}  {''.join(ticks).rstrip()}"
    reaches = {pinger.name: round(2e9 * pinger.reach / speed) for pinger in plan.pingers}
    for name in (name for volley in plan.volleys for name in volley.members):
        row = [_IDLE] * columns
        for number in range(cycles):
            row[number * plan.period_ns // column_ns] = _CYCLE if number else _IDLE
        for number in range(cycles):
            start_ns = plan.slots[name].planned_ns(number) % total_ns
            first, last = start_ns // column_ns, (start_ns + reaches[name]) // column_ns
            row[first : last + 1] = [_FIRES, *[_LISTENS] * (last - first)]
        yield f"{name.ljust(margin)}  {''.join(row[:columns])}"
    cycle = f", {_CYCLE} the next cycle" if cycles > 1 else ""
    yield f"{_FIRES} fires, {_LISTENS} listens{cycle}; a column is {column_ns * 1e-6:g} ms"


def _plural(count: int, what: str) -> str:
    return f"{count} {what}{'' if count == 1 else 's'}"
