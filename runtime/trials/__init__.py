"""Trials of avoidance: a robot that drives by its own senses, in emulated worlds."""
