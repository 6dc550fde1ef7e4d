"""Equilibrium: pattern and assembly, supports, linear solvers, schemes."""
