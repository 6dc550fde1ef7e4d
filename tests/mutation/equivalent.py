"""Mutants that compute the same as the program, each with why: file, line of the program and of the mutant."""

EQUIVALENT: dict[tuple[str, str, str], str] = {}
