"""Check the certificates of a results folder from its files alone: ``python verify_certificate OUT``.

This folder works alone: of the package it imports nothing, only NumPy. Copy it anywhere. What each ground proves is in
docs/theory_certificates.md; what the arrays are in docs/user_guide.md. Exit code 0: every verdict is confirmed; 1: one
does not.
"""

from .arrays_file import read_arrays
from .folder import main
from .mechanism import proved
from .stage import check_stage
from .strength import strength_of

__all__ = ["check_stage", "main", "proved", "read_arrays", "strength_of"]
