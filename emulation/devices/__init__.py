"""Emulated devices: each with its state, its physics and faults in one half, and its bytes in the other."""
