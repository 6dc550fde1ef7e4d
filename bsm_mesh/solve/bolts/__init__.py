"""Rockbolts: axial chains with bond slip, dowels across joints, their forces, tangent and record."""
