"""Stages one after the other: excavation, fill, loads, and every unstable block."""
