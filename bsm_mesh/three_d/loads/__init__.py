"""What acts on polyhedra from outside: weights, loads, water."""
