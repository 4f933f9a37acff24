"""What people would use instead: subjects on the host, and peers from PyPI, under the same contract."""
