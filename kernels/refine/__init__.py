"""Mesh refinement: a coarse mesh, refined triangle by triangle on the device."""
