"""All pilots, by name."""

from collections.abc import Mapping

from echogrid.runtime.trials.pilot import Hiring
from echogrid.runtime.trials.simple_pilots import Blind, SingleScan
from echogrid.runtime.trials.steered_pilots import guided, mapped, planned, vff, vfh, vfh_plus

PILOTS: Mapping[str, Hiring] = {
    "blind": Blind,
    "single-scan": SingleScan,
    "vff": vff,
    "vfh": vfh,
    "vfh-plus": vfh_plus,
    "planned": planned,
    "guided": guided,
    "mapped": mapped,
}
