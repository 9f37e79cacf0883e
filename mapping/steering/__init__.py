"""Steering past obstacles: from a local grid and a goal to a heading and a twist, and out of corners."""
