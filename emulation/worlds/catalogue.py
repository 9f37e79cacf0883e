"""The worlds in which maps and filters are judged, each with a round of at least 60 m through it.

Frozen on 2026-11-25, together with the acoustic parameters: whoever changes either re-runs every baseline.
The parameters were chosen by the office and the clutter alone. The workshop and the museum were written last;
nothing was ever tuned on them, and nothing should be.
"""

from collections.abc import Callable, Mapping

from echogrid.emulation.offices import office, office_tour
from echogrid.emulation.worlds.clutter import clutter
from echogrid.emulation.worlds.corridor import corridor
from echogrid.emulation.worlds.foyer import foyer
from echogrid.emulation.worlds.home import home
from echogrid.emulation.worlds.museum import museum
from echogrid.emulation.worlds.venue import Venue
from echogrid.emulation.worlds.warehouse import warehouse
from echogrid.emulation.worlds.workshop import workshop

WORLDS: Mapping[str, Callable[[], Venue]] = {
    "office": lambda: Venue(office(), office_tour()),
    "corridor": corridor,
    "clutter": clutter,
    "warehouse": warehouse,
    "home": home,
    "foyer": foyer,
    "workshop": workshop,
    "museum": museum,
}
