"""The obstacle view's ways out. None of them may wait, and none knows another."""
