"""Blocks as they are given: polyhedra, their masses, the polygons and points in which they touch."""
