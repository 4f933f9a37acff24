"""Bicubic Bezier patches as triangles: Concheiro 2013, chapters 2 to 5."""
