"""Planning over what the robot has seen so far: which way leads to the goal, and where to head for now."""
