"""Weights, given loads and water on polyhedra."""
