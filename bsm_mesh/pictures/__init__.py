"""Pictures of models, results, comparisons and studies."""
