"""Input with polyhedra: supports, possible contents of a model, a part of the blocks, readiness for a run."""
