"""Limit analysis: static admissibility and load factors by linear programming."""
