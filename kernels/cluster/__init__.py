"""Simplification by clustering: the vertices of a mesh that share a cell become one."""
