"""What is made of records alone: rows, tables, charts, pictures, one page, comparisons."""
