"""A throw-away machine with a kernel that has CAN, I2C, USB/IP, udev and systemd, for one command."""
