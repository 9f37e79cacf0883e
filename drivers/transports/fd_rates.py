"""The data phase of CAN-FD, as every FD device here wants it: that of moteus."""

DATA_BITRATE = 5_000_000
SAMPLE_POINT = 66.6
"""Percent of a bit, of both bit rates."""
