"""Run the cases, and write their tables into the manual: ``python -m verification [NAME ...] [--check] [--quick]``.

As ``python -m examples.numbers`` does for the other pages: ``--check`` changes nothing, and ends with exit code 1 where
a number differs by more than its table allows; ``--quick`` leaves out what takes minutes.
"""

from __future__ import annotations

import sys

from examples.numbers.command import write_or_check
from verification.manual import TABLES

if __name__ == "__main__":
    sys.exit(write_or_check(TABLES, __doc__))
