"""What decides where the robot drives."""
