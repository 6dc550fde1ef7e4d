"""Bolts in space: places of their nodes, dowels across joints, forces in explicit motion."""
