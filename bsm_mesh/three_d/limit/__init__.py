"""Limit analysis with friction cones: forces within strength, or the mechanism that proves that there are none."""
