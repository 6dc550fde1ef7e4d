"""A results folder: written by a run, checkpoints, resumed, saved and loaded, verified."""
