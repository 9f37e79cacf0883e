"""Ports: what moves bytes, transfers and frames between a bus and its devices."""
