"""Explicit motion of polyhedra: compiled cycles, and the windows that they make."""
