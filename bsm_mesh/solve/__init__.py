"""Solution of a model: stages, schemes, limit analysis. docs/architecture.md says where each equation is."""
