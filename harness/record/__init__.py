"""What a run leaves in its folder, written as it happens and checked as it is read."""
