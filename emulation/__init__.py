"""The emulated robot: world, acoustics, device emulators, wires, faults."""
