"""Surfaces as square images of samples: how a mesh becomes one, and what can be drawn from it."""
