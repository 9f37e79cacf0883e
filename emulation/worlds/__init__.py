"""Worlds to be judged in, by name."""

from echogrid.emulation.worlds.catalogue import WORLDS
from echogrid.emulation.worlds.venue import Venue

__all__ = ["WORLDS", "Venue"]
