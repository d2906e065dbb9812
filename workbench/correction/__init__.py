"""Offline path modification: commands that put the extended robot's tool where the path wants it."""
