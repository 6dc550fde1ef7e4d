"""The verification manual: cases with answers that nobody here made, and the equations of the thesis with their proof.

``python -m verification`` runs every case and writes the tables of docs/verification.md and docs/equations.md;
``tests/verification/test_manual.py`` runs the quick ones. A case is a function that returns the exact answer and ours.
"""
