"""Stages one after the other: what is taken away, placed and loaded, and every unstable block."""
