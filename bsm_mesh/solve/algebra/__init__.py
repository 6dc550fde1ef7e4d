"""Linear algebra of blocks: the matrix of 3 x 3 blocks, constraints, mechanisms, direct solvers, reactions."""
