"""Studies: many runs of a model whose keys take other values. Sampled, run in parallel, kept as a table, summed up."""
