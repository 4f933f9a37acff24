"""Reproduced tables and figures: one file each, its cases, columns and published values as data."""
