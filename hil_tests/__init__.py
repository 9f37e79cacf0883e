"""The bench: echogrid against devices of a real kernel, in a guest or on real ports."""
