"""Emulated buses: they carry what devices and host send, in the time it takes on the wire."""
