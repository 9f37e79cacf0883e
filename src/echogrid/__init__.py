"""echogrid: a live, time-true occupancy grid and obstacle sensor from sonars and wheel encoders."""

__version__ = "0.1.0"
