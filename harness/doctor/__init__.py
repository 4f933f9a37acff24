"""What is wrong with OpenCL on this machine, and the exact line that mends it."""
