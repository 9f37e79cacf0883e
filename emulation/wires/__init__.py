"""How the emulated devices are reached: in memory, or through real ptys and sockets."""
