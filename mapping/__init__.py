"""Pure mathematics on arrays: poses, sonar cones, grids, maps. No clock, file, socket, thread or log."""
