"""The `lodbench` command: one file per group of commands, and what they share."""
