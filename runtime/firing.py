"""When each ranger fires."""

from echogrid.drivers.role import Slot
from echogrid.runtime.config import Config


def firing_slots(config: Config) -> dict[str, Slot]:
    """When each ranger of a firing group fires; without groups, all fire one by one."""
    groups = config.firing.groups or tuple((sensor.name,) for sensor in config.sensor)
    gap_ns = round(config.firing.gap_ms * 1e6)
    period_ns = gap_ns * len(groups)
    return {name: Slot(period_ns, turn * gap_ns) for turn, group in enumerate(groups) for name in group}
