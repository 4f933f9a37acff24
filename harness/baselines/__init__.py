"""What people would use instead, behind the same contract: no kernels here."""
