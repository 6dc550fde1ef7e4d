"""Contact points on shared polygons: properties, state, forces, tangent, history; rotations."""
