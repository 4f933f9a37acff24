"""What is measured: subjects by name, groups that take turns, sweeps, and what a table is."""
