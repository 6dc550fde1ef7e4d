"""Check the certificates of a results folder from its files alone: ``python verify_certificate OUT``.

This folder imports NumPy and nothing else of the package. Copy it anywhere. docs/theory_certificates.md describes the
proof of each ground, docs/certificates.md the arrays. Exit code 0: every verdict is confirmed; 1: one is not.
"""

from .arrays_file import read_arrays
from .folder import main
from .mechanism import proved
from .stage import check_stage
from .strength import strength_of

__all__ = ["check_stage", "main", "proved", "read_arrays", "strength_of"]
