"""Iterative methods for the equations of one step, each with its compiled kernels."""
