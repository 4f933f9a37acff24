"""Systems by datasets, measured: registry, timing, records, tables, command line."""
