"""Devices and their bytes -> stamped readings. Knows nothing of maps."""
