"""What is given with polyhedra: supports, what a model may hold, a part of the blocks, readiness for a run."""
