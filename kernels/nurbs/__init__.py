"""NURBS surfaces as triangles: Concheiro 2013, chapter 6."""
