"""Blocks in three dimensions: polyhedra, the polygons in which they touch, limit analysis, key blocks.

Conventions: x east, y north, z up [m]; SI units, forces in N. The dip direction is clockwise from north, in degrees.
Rotations are vectors, positive by the right-hand rule. Stress and normal force are positive in tension.
"""
