"""One step: the block system, its equations and residual, subproblems of some blocks, factorization."""
