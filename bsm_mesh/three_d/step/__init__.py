"""The block system of polyhedra: loads, supports and contacts at a position."""
